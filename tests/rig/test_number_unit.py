"""Units of numbers, by what the drive is given."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import parse_rig, simulate
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
        ("duty", ("V", "V/s", "1/V", "s", "1/rad", "N m")),
    ],
)
def test_volts_of_a_drive_are_what_it_is_given(acts_on: str, units: tuple[str, ...]) -> None:
    rig = parse_rig(JOINT.format(acts_on))
    assert tuple(unit_in_rig(rig, name) for name in ASKED) == units


def test_a_duty_of_a_known_supply_is_a_voltage() -> None:
    rig = replace(parse_rig(JOINT.format("duty")), driven=Driven("goal_rad", False, True))
    assert unit_in_rig(rig, "drive.deadzone.u_0") == "V" and unit_in_rig(rig, "drive.servo.kp") == "1/rad"


@pytest.mark.parametrize("supplied", [False, True])
def test_what_a_drive_makes_of_a_duty_is_in_volts(supplied: bool) -> None:
    """A dead zone of 5 V behind a supply of 12 V holds up a duty of 0.4, and lets one of 0.5 through."""
    rig = parse_rig(JOINT.format("duty").partition("[drive.servo]")[0] + "resistance = 1.0\n[drive]\nsupply = 12.0\n")
    rig = replace(rig, effects={"drive.deadzone": {"u_0": 5.0, "j": 0.0}}, driven=Driven("duty", False, supplied))
    assert unit_in_rig(rig, "drive.deadzone.u_0") == "V"
    time, more = 0.01 * np.arange(50), {"supply_V": np.full(50, 12.0)} if supplied else {}
    low, high = (float(simulate(rig, time, {"duty": np.full(50, duty)} | more)["yaw_rad_s"][-1]) for duty in (0.4, 0.5))
    assert low == 0.0 < high


def test_a_rig_without_a_loop_takes_the_unit_of_its_command() -> None:
    rig = platform()
    assert unit_in_rig(rig, "drive.bias.u_b") == "V"
    assert unit_in_rig(replace(rig, driven=Driven("duty")), "drive.bias.u_b") == "V"
    assert unit_in_rig(replace(rig, driven=Driven("command_A")), "drive.bias.u_b") == "A"
    assert unit_in_rig(rig, "axis.inertia") == "kg m2" and unit_in_rig(rig, "drive.gain") == "N m/V"
