"""Delays of rigs, and of many plants of one rig."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.control.delays import delays_of
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform

LATE = replace(platform(), effects={"drive.delay": {"tau": 0.003}, "sensor.delay": {"tau": 0.005}})


def test_a_loop_knows_the_sum_of_both_delays() -> None:
    found = delays_of(LATE)
    assert (found.commands.tolist(), found.readings.tolist()) == ([0.003], [0.005])
    assert found.loop == pytest.approx([0.008])
    assert delays_of(platform()).loop.tolist() == [0.0]


def test_every_plant_has_its_own_delay() -> None:
    structure = structure_of(LATE)
    thetas = np.tile(theta_of(LATE, structure), (3, 1))
    thetas[:, structure.names.index("drive.delay.tau")] = [0.0, 0.01, 0.02]
    assert delays_of(LATE, thetas).loop == pytest.approx([0.005, 0.015, 0.025])
