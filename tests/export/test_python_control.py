"""The python-control plant: poles of the rig, and the describing function of its friction."""

from dataclasses import replace

import control
import numpy as np
import pytest

from rwjax.control.linear import linearised
from rwjax.export.python_control import describing_function, python_control
from rwjax.rig.model import Rig
from tests.systems import platform, reaction


def plant_of(rig: Rig, *amplitude: float) -> control.StateSpace:
    """What the function `plant` of the written file gives."""
    names: dict = {}
    exec(compile(python_control(rig).text, "plant.py", "exec"), names)
    return names["plant"](*amplitude)


def test_the_plant_without_dry_friction_is_the_linearised_rig() -> None:
    rig = reaction()
    found, ours = plant_of(rig), linearised(rig)
    s = 2.0j
    wanted = ours.C @ np.linalg.solve(s * np.eye(len(ours.A)) - ours.A, ours.B)
    assert complex(found(s)) == pytest.approx(complex(wanted), rel=1e-9)


def test_the_file_says_what_it_needs() -> None:
    assert "\n# It needs python-control: pip install control\n" in python_control(reaction()).text


def test_the_slope_of_a_constant_level_is_that_of_the_textbook() -> None:
    a = np.array([0.1, 1.0, 10.0])
    assert describing_function(platform("coulomb = 0.05"), a) == pytest.approx(4.0 * 0.05 / (np.pi * a), rel=1e-5)
    assert not describing_function(platform("viscous = 0.02"), a).any()


def test_friction_damps_a_small_oscillation_more() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05")
    poles = sorted(plant_of(rig, 0.1).poles().real)
    assert poles == pytest.approx([-(0.02 + 4.0 * 0.05 / (np.pi * 0.1)) / 0.1, 0.0], rel=1e-3, abs=1e-9)
    assert sorted(plant_of(rig).poles().real) == pytest.approx([-0.2, 0.0], abs=1e-9)


def test_between_and_beyond_the_table_the_slope_of_a_level_is_exact() -> None:
    rig = platform("viscous = 0.0\ncoulomb = 0.05")
    for a in (1e-4, 0.0137, 500.0):
        assert min(plant_of(rig, a).poles().real) == pytest.approx(-4.0 * 0.05 / (np.pi * a) / 0.1, rel=1e-4)


def test_what_small_motions_do_not_show_is_left_out() -> None:
    effects = {"drive.deadzone": {"u_0": 0.4, "j": 0.0}, "axis.viscous": {"b": 0.1}, "axis.load_friction": {"mu": 0.1}}
    left = python_control(replace(platform(), name='C:\\U """', effects=effects)).left_out
    assert {*left} == {"drive.deadzone", "axis.load_friction"}
    plant_of(replace(platform(), name='C:\\U """'))


def test_a_delay_is_left_out() -> None:
    rig = replace(platform(), effects={"drive.delay": {"tau": 0.02}})
    assert {*python_control(rig).left_out} == {"drive.delay"}
