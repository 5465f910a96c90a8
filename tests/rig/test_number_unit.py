"""Units of numbers, by what the drive is given."""

from dataclasses import replace

import pytest

from rwjax import parse_rig
from rwjax.rig.model import Driven
from rwjax.rig.number_unit import unit_in_rig
from tests.systems import platform

JOINT = (
    'kind = "joint"\n[axis]\ninertia = 0.01\n[motor]\ntorque_constant = 0.1\n[drive.servo]\nacts_on = "{}"\nkp = 5.0\n'
)
ASKED = (
    "drive.deadzone.u_0",
    "drive.rate_limit.r",
    "drive.curvature.c",
    "drive.delay.tau",
    "drive.servo.kp",
    "axis.coulomb.M_c",
)


@pytest.mark.parametrize(
    ("acts_on", "units"),
    [
        ("torque", ("N m", "N m/s", "1/(N m)", "s", "N m/rad", "N m")),
        ("current", ("A", "A/s", "1/A", "s", "A/rad", "N m")),
        ("voltage", ("V", "V/s", "1/V", "s", "V/rad", "N m")),
        ("duty", ("", "1/s", "", "s", "1/rad", "N m")),
    ],
)
def test_volts_of_a_drive_are_what_it_is_given(acts_on: str, units: tuple[str, ...]) -> None:
    rig = parse_rig(JOINT.format(acts_on))
    assert tuple(unit_in_rig(rig, name) for name in ASKED) == units


def test_a_duty_of_a_known_supply_is_a_voltage() -> None:
    rig = replace(parse_rig(JOINT.format("duty")), driven=Driven("goal_rad", False, True))
    assert unit_in_rig(rig, "drive.deadzone.u_0") == "V"


def test_a_rig_without_a_loop_takes_the_unit_of_its_command() -> None:
    rig = platform()
    assert unit_in_rig(rig, "drive.bias.u_b") == "V"
    assert unit_in_rig(replace(rig, driven=Driven("duty")), "drive.bias.u_b") == ""
    assert unit_in_rig(rig, "axis.inertia") == "kg m2" and unit_in_rig(rig, "drive.gain") == "N m/V"
