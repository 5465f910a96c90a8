"""Which numbers of a servo's first rig file are free."""

from rwjax.methods.known import Known
from rwjax.methods.servo_scale import servo_numbers

FREE = Known(1.0, "a guess", free=True)
JOINT = {"motor.torque_constant": FREE, "axis.inertia": FREE, "axis.friction.viscous": FREE}


def free_of(
    numbers: dict[str, Known], *, inertia: bool = False, current: bool = False, wheel: bool = False
) -> set[str]:
    """Names of the numbers that are free."""
    found = servo_numbers(numbers, inertia_known=inertia, current=current, wheel_measured=wheel)
    return {name for name, known in found.items() if known.free}


def test_a_guessed_gain_is_fixed_and_says_what_to_give_instead() -> None:
    assert free_of(JOINT) == {"axis.inertia", "axis.friction.viscous"}
    kp = servo_numbers(JOINT, inertia_known=False, current=False, wheel_measured=False)["drive.servo.kp"]
    assert "fixed" in kp.why and "--axis-inertia" in kp.why


def test_a_known_inertia_or_weight_frees_the_gain() -> None:
    known = JOINT | {"axis.inertia": Known(0.1, "given")}
    assert free_of(known, inertia=True) == {"axis.friction.viscous", "drive.servo.kp"}
    weighed = JOINT | {"axis.gravity.torque": FREE}
    assert free_of(weighed) == {"axis.inertia", "axis.friction.viscous", "drive.servo.kp"}
    assert "axis.gravity.torque" in free_of(weighed | {"axis.inertia": Known(0.1, "given")}, inertia=True)


def test_a_current_tells_the_torque_constant_and_the_motor_s_friction() -> None:
    numbers = JOINT | {"motor.friction": FREE}
    assert {"motor.torque_constant", "motor.friction"} <= free_of(numbers, current=True)
    assert {"motor.torque_constant", "motor.friction"} & free_of(numbers, wheel=True) == {"motor.torque_constant"}


def test_a_gain_of_the_drive_acts_as_the_servo_s_does() -> None:
    assert "drive.gain" not in free_of({"drive.gain": FREE, "axis.inertia": Known(0.1, "given")}, inertia=True)


def test_a_gain_that_is_given_is_known_and_a_weight_is_then_told_by_it() -> None:
    numbers = JOINT | {"axis.gravity.torque": FREE}
    found = servo_numbers(numbers, inertia_known=False, current=False, wheel_measured=False, kp=3.0, kd=0.0)
    assert found["drive.servo.kp"] == Known(3.0, "given") and found["drive.servo.kd"] == Known(0.0, "given")
    assert found["axis.gravity.torque"].free
