"""What a user does in the place of an effect that a MuJoCo model cannot hold, or of a rig that a tool does not take."""

from rwjax.effects.effect import Effect
from rwjax.effects.ports import (
    AxisTorque,
    Clock,
    CommandDelay,
    CommandFilter,
    CommandMap,
    Coupling,
    CurrentLimit,
    Dry,
    Encoder,
    EncoderDelay,
    GoalDelay,
    MotorTorque,
    Reading,
    Supply,
    WheelTorque,
    Winding,
)

OWN_LOOP = "close the loop in your own code, with the drive's command as control"
PLACES: tuple[tuple[tuple[type[Effect], ...], str], ...] = (
    ((CommandMap, CommandDelay, CommandFilter), "apply it to the command before the actuator"),
    ((GoalDelay,), "apply it to the goal before the actuator"),
    ((Encoder, EncoderDelay, Reading, Clock), "apply it to what the sensors give"),
    ((AxisTorque, Dry, WheelTorque), "add its torque to the hinge at every step (`qfrc_applied`)"),
    ((Supply, MotorTorque, CurrentLimit, Winding), "work out the motor's torque in your own code, with it as control"),
    ((Coupling,), "give both sides of it a hinge of their own"),
)
"""What to do instead, by where in the plant the effect acts."""

AS_JOINT = (
    "logs of a wheel can be exported as a `joint`: name their columns `yaw_rad_s`, `yaw_rad` or `yaw_counts` in place of `wheel_…`, then "
    "`rwjax init --kind joint`"
)
"""What to do for an export that needs an axis, in the place of a rig of kind `wheel`."""


def instead(effect: type[Effect]) -> str:
    """What to do in the place of an effect that a model lacks.

    Args:
        effect: The effect's class.

    Returns:
        A clause; "" where the model has no place for it whatever one does.
    """
    return next((words for ports, words in PLACES if issubclass(effect, ports)), "")
