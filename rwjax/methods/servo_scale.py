"""Which numbers of a first rig file a servo's logs tell: angles know torques up to one common factor, which something has to fix."""

from rwjax.methods.known import Known
from rwjax.rig.model import GUESS

KP, KD, GRAVITY, GAIN = "drive.servo.kp", "drive.servo.kd", "axis.gravity.torque", "drive.gain"
TORQUE_CONSTANT, MOTOR_FRICTION = "motor.torque_constant", "motor.friction"
FIXED = f"{GUESS}, fixed: torques and inertias are in proportion to it; give the true gain by --kp, or --axis-inertia and kp is free instead"
GIVEN = "given"


def servo_numbers(
    numbers: dict[str, Known],
    *,
    inertia_known: bool,
    current: bool,
    wheel_measured: bool,
    kp: float | None = None,
    kd: float | None = None,
) -> dict[str, Known]:
    """The numbers of a rig whose logs hold a servo's goal: free are those alone that such logs can tell apart.

    * The gain kp is free where it is not given and an inertia is known, or the torque of a weight on a lever, which is then fixed. Else kp is fixed.
    * A gain of the drive acts as kp does, so it is fixed.
    * A torque constant is told from the gain by a current or by the wheel's rate, and a motor's friction from the back-EMF by a current.

    Args:
        numbers: Every number of the rig without a servo, by its name [SI].
        inertia_known: Whether the datasheet gives an inertia.
        current: Whether the logs hold the current.
        wheel_measured: Whether they hold the rate of a wheel.
        kp: The gain that is given [V/rad, or by what the servo acts on]; None for a guess.
        kd: The rate gain that is given [V s/rad, or by what the servo acts on]; None for a guess.

    Returns:
        The numbers [SI], those of the servo among them.
    """
    found = dict(numbers)
    weighed = GRAVITY in found and not inertia_known and kp is None
    if weighed:
        found[GRAVITY] = _fixed(found[GRAVITY], "fixed: it tells the scale of all torques and inertias")
    for name, told in ((GAIN, False), (TORQUE_CONSTANT, current or wheel_measured), (MOTOR_FRICTION, current)):
        if name in found and found[name].free and not told:
            found[name] = _fixed(found[name], "fixed: a servo's logs tell it together with kp alone")
    known = inertia_known or weighed
    found[KP] = Known(10.0, f"{GUESS}, or --kp" if known else FIXED, free=known) if kp is None else Known(kp, GIVEN)
    found[KD] = Known(0.0, f"{GUESS}, or --kd") if kd is None else Known(kd, GIVEN)
    return found


def _fixed(known: Known, why: str) -> Known:
    """A number that a fit leaves as it is, with the reason beside where it comes from."""
    return known._replace(why=f"{known.why}, {why}", free=False)
