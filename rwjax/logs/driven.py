"""How a rig was driven in a set of logs: by which command, from a logged supply or not, with torque on all the time or not."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax.errors import LogError, RigError
from rwjax.kinds import GIVEN, GOAL, SERVO, TWO_AXIS
from rwjax.logs.log import Log
from rwjax.rig.model import Driven, Rig

NEEDED = {
    "voltage": ("motor.torque_constant", "motor.resistance"),
    "duty": ("motor.torque_constant", "motor.resistance"),
    "current": ("motor.torque_constant",),
    "torque": (),
}
"""Numbers of a joint without which what the drive is given makes no torque."""


def driven(rig: Rig, logs: Sequence[Log]) -> tuple[Rig, tuple[Log, ...]]:
    """A rig as it was driven in some logs, and these logs, a duty beside the supply's logged voltage as the voltage that it is.

    Args:
        rig: The rig.
        logs: The logs.

    Returns:
        The rig with `driven` set, and the logs.

    Raises:
        LogError: Where the logs hold different commands, or one that this rig cannot be driven by.
    """
    if not logs or rig.kind in TWO_AXIS:
        return rig, tuple(logs)
    first = logs[0]
    if other := next((log for log in logs if log.input != first.input), None):
        raise LogError(
            f"{first.name} holds `{first.input}` and {other.name} `{other.input}`; all logs of one rig hold the same command: "
            "take them one kind after the other"
        )
    logs = _with_supply(rig, logs)
    unsupplied = next((log for log in logs if log.supply is None), None)
    off = next((log for log in logs if log.enabled is not None and not log.enabled.all()), None)
    supplied = unsupplied is None
    try:
        rig = driven_by(rig, first.input, off is not None, supplied)
    except RigError as error:
        about = off if off is not None and rig.kind == "platform" else unsupplied
        raise LogError(f"{(about or first).name}: {error}") from None
    if first.input == "duty" and supplied:
        logs = [replace(log, command=log.command * log.supply, input="voltage_V") for log in logs]
    if first.input == GOAL:
        logs = [replace(log, acting=_acting(rig, log, supplied)) for log in logs]
    return replace(rig, driven=rig.driven._replace(by=logs[0].input)), tuple(logs)


def without_servo(rig: Rig, logs: Sequence[Log]) -> tuple[Rig, tuple[Log, ...]]:
    """A rig and its logs as if what a servo gave had been logged, for methods that simulate no loop.

    Args:
        rig: The rig.
        logs: The logs.

    Returns:
        The rig and the logs as `driven` has them, a goal replaced by what the servo gave by the readings.

    Raises:
        LogError: As `driven`.
    """
    rig, logs = driven(rig, logs)
    if rig.servo is None or rig.driven.by != GOAL:
        return rig, logs
    column = next(name for name, given in GIVEN.items() if given == rig.servo.acts_on)
    if column == "duty" and rig.driven.supplied:
        column = "voltage_V"
    opened = (replace(log, command=log.at_drive, input=column, acting=None) for log in logs)
    return replace(rig, driven=rig.driven._replace(by=column)), tuple(opened)


def driven_by(rig: Rig, column: str, switched: bool = False, supplied: bool = False) -> Rig:
    """A rig as a command drives it.

    Args:
        rig: The rig.
        column: Column of the command, as `voltage_V` or `goal_rad`.
        switched: Whether torque is off at times.
        supplied: Whether the voltage of the supply is known besides.

    Returns:
        The rig with `driven` set.

    Raises:
        RigError: Where it cannot be driven so: without a servo for a goal, without a supply for a duty, without a number of its
            motor for a joint, without a motor for torque that is off.
    """
    if column == GOAL and rig.servo is None:
        raise RigError(f"`{GOAL}` needs the loop that follows it; write [{SERVO}] in the rig file")
    by = rig.servo.acts_on if column == GOAL and rig.servo is not None else GIVEN[column]
    if by == "duty" and not supplied and "drive.supply" not in rig.numbers:
        raise RigError("a duty needs the supply's voltage; log `supply_V`, or write [drive] supply = …")
    if rig.kind == "joint" and (missing := [name for name in NEEDED[by] if name not in rig.numbers]):
        raise RigError(f"driven by {by}, a joint needs `{missing[0]}` in the rig file")
    if switched and rig.kind == "platform":
        raise RigError("`enabled` is 0, and a `platform` has no motor whose circuit could be open")
    return replace(rig, driven=Driven(column, switched, supplied))


def _with_supply(rig: Rig, logs: Sequence[Log]) -> Sequence[Log]:
    """Logs of which all or none hold the supply's voltage, where the rig file has one for those that lack it."""
    volts = rig.numbers.get("drive.supply")
    if volts is None or len({log.supply is None for log in logs}) == 1:
        return logs
    return [log if log.supply is not None else replace(log, supply=np.full(len(log.time), volts)) for log in logs]


def _acting(rig: Rig, log: Log, supplied: bool) -> np.ndarray:
    """What a servo gave from sample to sample (n,), by the rig file's numbers and the logged positions; 0 without these."""
    if "yaw_rad" not in log.outputs or rig.servo is None:
        return np.zeros(len(log.time))
    n = {
        name.removeprefix(f"{SERVO}."): value + log.added.get(name, 0.0)
        for name, value in rig.numbers.items()
        if name.startswith(f"{SERVO}.")
    }
    read = np.isfinite(log.outputs["yaw_rad"])
    position = np.interp(log.time, log.time[read], log.outputs["yaw_rad"][read])
    error = np.clip(log.command - position, -n.get("error_limit", np.inf), n.get("error_limit", np.inf))
    damped = error if rig.servo.damping_on == "error" else -position
    step = np.diff(log.time, prepend=log.time[0] - np.median(np.diff(log.time)))
    on = np.ones(len(step), bool) if log.enabled is None else log.enabled
    most = min(n.get("limit", np.inf), 1.0 if rig.servo.acts_on == "duty" else np.inf)
    given, slope, whole = np.zeros(len(step)), 0.0, 0.0
    for k, dt in enumerate(step):
        slope += (damped[k] - damped[max(k - 1, 0)] - dt * slope) / (n.get("derivative_filter", 0.0) + dt)
        asked = n["kp"] * error[k] + n.get("ki", 0.0) * whole + n.get("kd", 0.0) * slope
        given[k] = min(max(asked, -most), most) if on[k] else 0.0
        if given[k] == asked or asked * error[k] < 0.0:
            whole += dt * error[k]
        whole *= on[k]
    sign = {"reaction": -1.0, "platform": np.sign(rig.numbers.get("drive.gain", 1.0))}.get(rig.kind, 1.0)
    volts = log.supply if supplied and rig.servo.acts_on == "duty" and log.supply is not None else 1.0
    return sign * volts * given
