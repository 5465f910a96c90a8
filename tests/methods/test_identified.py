"""What a method returns, and what it says of a rig file that it does not use."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import RigError
from rwjax.methods.identified import Identified, at_the_drive, estimated, left_out, undelayed
from tests.joints import joint, logged, servo
from tests.systems import platform

RIG = platform(free='"axis.inertia", "axis.friction.viscous"')


def test_estimates_stand_in_the_rig_with_the_standard_errors_that_are_finite() -> None:
    names = ("axis.inertia", "axis.friction.viscous")
    found = Identified(estimated(RIG, names, np.array([0.2, 0.03]), np.array([0.01, np.inf])), ("so",))
    assert found.rig.values["axis.inertia"] == 0.2 and found.rig.values["axis.friction.viscous"] == 0.03
    assert found.rig.standard_error == {"axis.inertia": 0.01}
    assert found.interval == {"axis.inertia": pytest.approx((0.2 - 0.0196, 0.2 + 0.0196))}
    numbers = found.json()["numbers"]
    assert numbers["axis.friction.viscous"] == {"value": 0.03, "standard_error": None}
    assert found.json()["notes"] == ["so"] and found.of_runs() == []


def test_a_note_names_the_keys_that_a_method_does_not_use() -> None:
    rig = replace(RIG, prior={"axis.inertia": (0.1, 0.01)}, per_run=("axis.inertia",))
    assert left_out(rig, prior=False) == ("does not know fit.prior and fit.per_run of the rig file",)
    assert left_out(rig, prior=True) == ("does not know fit.per_run of the rig file",)
    assert left_out(RIG, prior=False) == ()


def test_late_readings_are_refused() -> None:
    undelayed(RIG, "method")
    with pytest.raises(RigError, match="has sensor.delay; the method takes readings to be at once"):
        undelayed(replace(RIG, effects={"sensor.delay": {"tau": 0.05}}), "method")


def test_numbers_of_a_servo_are_left_to_methods_that_simulate_its_loop() -> None:
    rig = replace(servo(joint()), free=("axis.inertia", "drive.servo.kp"))
    t = np.arange(200) * 0.01
    log = logged(rig, t, goal_rad=np.sin(3.0 * t))
    opened, (as_voltage,), notes = at_the_drive(rig, [log], "weak form")
    assert opened.free == ("axis.inertia",) and as_voltage.input == "voltage_V" and opened.driven.by == "voltage_V"
    error = log.command[:-1] - log.outputs["yaw_rad"][:-1]
    np.testing.assert_allclose(as_voltage.command[:-1], 8.0 * error, atol=1e-12)
    assert notes == (
        "what the servo gave is worked out from the readings",
        "drive.servo.kp is not estimated by the weak form",
    )
    with pytest.raises(RigError, match="no free number acts in these logs; the weak form simulates no loop of a servo"):
        at_the_drive(replace(rig, free=("drive.servo.kp",)), [log], "weak form")
