"""Dumping the wheel's momentum into static friction: the bound, the axis that does not move, and one that does."""

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.dumping import dump
from rwjax.control.open_loop import Limits, course, steady
from rwjax.errors import InputError
from tests.systems import MOTOR, reaction

SPIN, HOLDS, J = 400.0, 0.015, 1.24e-4
TESTBED = reaction(f"coulomb = 0.01\nstatic = {HOLDS}\nstribeck_velocity = 0.2")
LIMITS = Limits(12.0, 3.0)


@pytest.mark.parametrize("spin", [SPIN, -SPIN])
def test_the_wheel_stops_near_the_bound_and_the_axis_does_not_move(spin: float) -> None:
    found = dump(TESTBED, spin, LIMITS)
    assert found.bound == pytest.approx(J * SPIN / (0.9 * HOLDS))
    assert found.bound < found.time < 1.05 * found.bound
    assert np.all(np.asarray(found.best.angle) == 0.0)  # held, not nearly held
    assert abs(float(found.best.wheel[-1])) < 1e-3 * SPIN
    assert np.max(np.abs(found.best.torque)) < 0.9 * HOLDS * 1.001


def test_a_stop_faster_than_the_bound_moves_the_axis() -> None:
    found = dump(TESTBED, SPIN, LIMITS, margin=0.98)
    structure, theta, start = steady(TESTBED, SPIN)
    for share, moves in ((1.0, False), (0.9, True)):
        run = course(structure, theta, found.best.command[:-1], share * found.time, start)
        assert bool(np.any(np.asarray(run.angle) != 0.0)) == moves


def test_a_held_load_takes_its_part_of_the_friction() -> None:
    load = 0.006
    loaded = parse_rig(
        f'kind = "reaction"\n{MOTOR}\n[axis]\ninertia = 0.0495\n[axis.friction]\ncoulomb = {HOLDS}\n'
        f'[effects."axis.bias_torque"]\nT = {load}'
    )
    assert dump(loaded, SPIN, LIMITS).bound == pytest.approx(J * SPIN / (0.9 * HOLDS - load))
    assert dump(loaded, -SPIN, LIMITS).bound == pytest.approx(J * SPIN / (0.9 * HOLDS + load))


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(InputError, match="nothing holds the axis"):
        dump(reaction(), SPIN, LIMITS)
    with pytest.raises(InputError, match="other than 0"):
        dump(TESTBED, 0.0, LIMITS)
    with pytest.raises(InputError, match=r"margin 1\.5"):
        dump(TESTBED, SPIN, LIMITS, margin=1.5)
