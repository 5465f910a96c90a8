"""A rig in memory: its values by name, other values in their place, and how it prints."""

import pytest

from rwjax.errors import RigError
from rwjax.rig.model import with_one_axis
from rwjax.rig.read import parse_rig
from tests.rig.texts import PLATFORM, REACTION
from tests.two_axes import two_axis


def test_estimates_take_their_place():
    rig = parse_rig(PLATFORM).with_values({"axis.inertia": 0.3})
    assert rig.numbers == {"drive.gain": -0.428, "axis.inertia": 0.3}
    with pytest.raises(KeyError, match="axis.friction.coulomb"):
        rig.with_values({"axis.friction.coulomb": 0.1})


def test_values_are_numbers_and_parameters_of_effects() -> None:
    rig = parse_rig(PLATFORM + '[effects."axis.stribeck"]\nM_c = 0.1\nM_e = 0.2\nv_s = 0.3\nn = 1\n')
    assert rig.values == rig.numbers | {
        "axis.stribeck.M_c": 0.1,
        "axis.stribeck.M_e": 0.2,
        "axis.stribeck.v_s": 0.3,
        "axis.stribeck.n": 1.0,
    }
    assert rig.with_values({"axis.stribeck.v_s": 0.5}).effects == {
        "axis.stribeck": {"M_c": 0.1, "M_e": 0.2, "v_s": 0.5, "n": 1.0}
    }


def test_a_rig_with_two_axes_is_none_with_one() -> None:
    rig = parse_rig(PLATFORM)
    assert with_one_axis(rig) is rig
    with pytest.raises(
        RigError, match="^kind `two_axis` has two axes, and this is for one; describe that axis by a `reaction` rig$"
    ):
        with_one_axis(two_axis())


def test_a_rig_prints_its_numbers_with_units_and_which_are_free() -> None:
    text = (
        REACTION
        + """[axis.friction]
viscous = 0.0026
[fit]
free = ["axis.inertia", "axis.stribeck.M_c"]
per_run = ["axis.stribeck.M_c"]
standard_error = { "axis.inertia" = 1.234e-4 }
[effects."axis.stribeck"]
M_c = 0.01
M_e = 0.02
v_s = 0.3
"""
    )
    assert (
        str(parse_rig(text, "testbed.toml"))
        == """\
reaction rig `testbed`
  motor: torque_constant = 0.0182 N m/A, resistance = 0.83 ohm
  wheel: inertia = 0.000124 kg m2
  axis: inertia = 0.0495 ± 0.00012 kg m2 (free), friction.viscous = 0.0026 N m s/rad
  axis.stribeck: M_c = 0.01 N m (free, per run), M_e = 0.02 N m, v_s = 0.3 rad/s, n = 2"""
    )
