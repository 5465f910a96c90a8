"""How logs say that a rig was driven."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.logs.driven import driven, without_servo
from rwjax.plant.from_rig import structure_of
from rwjax.rig.model import Rig
from tests.joints import joint, logged, servo

T = np.arange(101) * 0.01
GOAL = 0.5 * np.sin(6.0 * T)
SUPPLY = 12.0 + 0.1 * T


def test_a_duty_beside_the_supply_is_a_voltage() -> None:
    log = logged(joint(), T, duty=0.1 * GOAL, supply_V=SUPPLY)
    rig, (found,) = driven(joint(), [log])
    assert (rig.driven.by, found.input) == ("voltage_V", "voltage_V")
    np.testing.assert_array_equal(found.command, 0.1 * GOAL * SUPPLY)
    assert driven(rig, [found])[0] == rig


def test_what_acts_says_which_numbers_are_in_the_plant() -> None:
    rig = joint(drive__supply=12.0)
    logs = {name: [logged(rig, T, **{name: 0.1 * GOAL})] for name in ("voltage_V", "duty", "command_A", "command_Nm")}
    names = {name: {*structure_of(driven(rig, one)[0]).numbers} for name, one in logs.items()}
    own = {"drive.supply", "motor.torque_constant", "motor.resistance"}
    assert {name: own & held for name, held in names.items()} == {
        "voltage_V": {"motor.torque_constant", "motor.resistance"},
        "duty": own,
        "command_A": {"motor.torque_constant"},
        "command_Nm": set(),
    }


def test_what_a_servo_gave_is_worked_out_from_what_was_read() -> None:
    """With the logged positions fed into the gains, and back as the command, the joint moves as it did."""
    rig = servo(joint(), kp=6.0, kd=0.05, derivative_filter=0.02, limit=2.0, period=0.01)
    closed = logged(rig, T, goal_rad=GOAL)
    opened, (log,) = without_servo(rig, [closed])
    assert log.input == "voltage_V" and opened.driven.by == "voltage_V" and structure_of(opened).servo is None
    again = logged(rig, T, voltage_V=log.command)
    np.testing.assert_allclose(again.outputs["yaw_rad"], closed.outputs["yaw_rad"], atol=5e-3)
    assert np.ptp(closed.outputs["yaw_rad"]) > 0.2 and np.max(np.abs(log.command)) <= 2.0


LOG = logged(joint(), T, voltage_V=GOAL)
WRONG = [
    (joint(), [LOG, replace(LOG, name="b.csv", input="duty")], "run.csv holds `voltage_V` and b.csv `duty`; "),
    (
        joint(),
        [replace(LOG, input="goal_rad")],
        "run.csv: `goal_rad` needs the loop that follows it; write [drive.servo]",
    ),
    (
        joint(),
        [replace(LOG, input="duty")],
        "run.csv: a duty needs the supply's voltage; log `supply_V`, or write [drive]",
    ),
    (
        joint(motor__resistance=0.0),
        [LOG],
        "run.csv: driven by voltage, a joint needs `motor.resistance` in the rig file",
    ),
    (
        Rig("platform", "p", {"drive.gain": 1.0, "axis.inertia": 1.0}),
        [replace(LOG, enabled=T < 0.5)],
        "run.csv: `enabled` is 0, and a `platform` has no motor whose circuit could be open",
    ),
]


@pytest.mark.parametrize(("rig", "logs", "said"), WRONG, ids=[said for *_, said in WRONG])
def test_a_rig_that_cannot_be_driven_so_is_refused(rig: Rig, logs: list, said: str) -> None:
    with pytest.raises(LogError) as error:
        driven(rig, logs)
    assert str(error.value).startswith(said)
