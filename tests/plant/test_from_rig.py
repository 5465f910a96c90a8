"""Between the rig file and the plant."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.plant.from_rig import bounds_of, rig_with, structure_of, theta_of
from tests.systems import platform, reaction, wheel
from tests.two_axes import GIMBAL, two_axis


def test_only_what_a_rig_has_is_compiled() -> None:
    assert structure_of(wheel()).inductive and not structure_of(wheel(0.0)).inductive
    assert "motor.inductance" not in structure_of(wheel(0.0)).names
    assert "axis.friction.coulomb" not in structure_of(platform("viscous = 0.02")).names
    with_load = structure_of(platform("viscous = 0.02\n[axis.gravity]\ntorque = 0.1"))
    assert {"axis.gravity.torque", "axis.gravity.angle"} <= {*with_load.names}
    assert {"motor_1.friction", "motor_2.friction"} <= {*structure_of(two_axis()).names}


@pytest.mark.parametrize("rig", [wheel(), platform(), reaction(), two_axis(GIMBAL)], ids=lambda rig: rig.kind)
def test_numbers_go_to_the_vector_and_back(rig) -> None:
    structure = structure_of(rig)
    theta = theta_of(rig, structure)
    for name, value in zip(structure.names, theta, strict=True):
        assert value == rig.values.get(name, 0.0), name
    back = rig_with(rig, structure, 1.5 * theta, {structure.names[0]: 0.1})
    assert back.values == pytest.approx({name: 1.5 * value for name, value in rig.values.items()})
    assert back.standard_error == {structure.names[0]: 0.1}


def test_an_effect_that_the_rig_lacks_stands_where_it_is_absent_and_is_added_to_the_rig() -> None:
    structure = structure_of(platform()).with_effects("axis.stribeck")
    theta = theta_of(platform(), structure)
    k = structure.names.index("axis.stribeck.M_e")
    assert theta[k] == 0.0 and theta[structure.names.index("axis.stribeck.v_s")] == 1.0
    theta[k] = 0.02
    assert rig_with(platform(), structure, theta, {}).effects["axis.stribeck"]["M_e"] == 0.02


def test_bounds_are_physical_and_narrowed_by_the_rig_file() -> None:
    rig = platform(free='"axis.inertia"]\n[fit.bounds]\n"axis.friction.coulomb" = [0.01, 0.2]\n#')
    bounds = dict(zip(structure_of(rig).names, bounds_of(rig, structure_of(rig)).tolist(), strict=True))
    assert 0.0 < bounds["axis.inertia"][0] < 1e-9 and bounds["axis.inertia"][1] == np.inf
    assert bounds["axis.friction.viscous"] == [0.0, np.inf]
    assert bounds["axis.friction.coulomb"] == [0.01, 0.2]
    assert bounds["drive.gain"] == [-np.inf, np.inf]


def test_bounds_of_the_file_leave_no_range_that_a_rig_file_may_not_hold() -> None:
    """Else a fit would end at a number that cannot be written."""
    rig = platform('viscous = 0.02\n[effects."drive.delay"]\ntau = 0.1\n')
    wide = {"axis.inertia": (-1.0, 2.0), "drive.delay.tau": (-1.0, 3.0), "axis.friction.viscous": (-0.1, 1.0)}
    rig = replace(rig, bounds=wide)
    bounds = dict(zip(structure_of(rig).names, bounds_of(rig, structure_of(rig)).tolist(), strict=True))
    assert bounds["axis.inertia"][0] > 0.0 and bounds["axis.inertia"][1] == 2.0
    assert bounds["drive.delay.tau"] == [0.0, 0.5] and bounds["axis.friction.viscous"] == [-0.1, 1.0]
