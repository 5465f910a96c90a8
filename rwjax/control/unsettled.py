"""Why a step does not settle: where friction holds an axis at rest under a controller without an integral, and how long under one with it."""

import math

from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.response import BAND

FRICTION = "friction holds the axis"
"""How a reason begins that is friction."""
LOADED = 1.1
"""Error over the largest that friction holds, above which a steady load holds the axis off, too [1]."""


def held_off(controller: Controller, breakaway: float) -> float:
    """Largest error at which a controller's proportional part and its feed-forward leave an axis at rest where it is.

    Args:
        controller: Gains, feed-forward and deadband; the integral does not count.
        breakaway: Command at which the axis at rest breaks loose [V].

    Returns:
        The error [rad]; infinite where `kp` is 0 and the feed-forward is too small.
    """
    kp, deadband = float(controller.kp), float(controller.deadband)
    within, beyond = (_over(volts, kp) for volts in (breakaway, breakaway - float(controller.feedforward)))
    return max(beyond, min(within, deadband))  # inside the deadband nothing is fed forward


def least_kp(controller: Controller, breakaway: float, error: float) -> float:
    """Proportional gain from which on an axis at rest is held off by no more than an error.

    Args:
        controller: Feed-forward and deadband; its gains do not count.
        breakaway: Command at which the axis at rest breaks loose [V].
        error: The error, above 0 [rad].

    Returns:
        The gain [V/rad], 0 where the feed-forward alone suffices.
    """
    forward = float(controller.feedforward) if error >= float(controller.deadband) else 0.0
    return max(breakaway - forward, 0.0) / error


def why_unsettled(controller: Controller, breakaway: float, step: float, timing: LoopTiming, error: float = 0.0) -> str:
    """Why a step of the reference from rest does not settle.

    Args:
        controller: Gains, feed-forward and deadband.
        breakaway: Command at which the axis at rest breaks loose [V].
        step: Height of the step [rad].
        timing: Sampling period, and the encoder's counts.
        error: Error that the step ends with [rad].

    Returns:
        The reason in words; one that is friction begins with `FRICTION`.
    """
    size, ki = abs(step), float(controller.ki)
    first = float(controller.kp) * size + float(controller.feedforward) * (size > float(controller.deadband))
    needs = f"{FRICTION} until the command is {breakaway:.3g} V"
    if breakaway > first and ki > 0.0:
        seconds = max((breakaway - first) / (ki * size), timing.period)
        return f"{needs}; the step gives {first:.3g} V with these gains, and ki makes up for the rest only in {seconds:.3g} s"
    if breakaway > first:
        return f"{needs}, and the step gives {first:.3g} V with these gains: the axis does not move at all"
    off = held_off(controller, breakaway)
    if ki == 0.0 and off > BAND * size:
        rest = "; the rest is a steady load's, such as gravity at that angle" if abs(error) > LOADED * off else ""
        return f"{needs}, so that at rest it stays up to {math.degrees(off):.2g}° off with these gains{rest}"
    count = 360.0 / timing.counts if timing.counts else 0.0
    if 0.5 * count > BAND * math.degrees(size):
        return (
            f"one count of the encoder is {count:.2g}°, so that the loop sees no error below half of it, and only what stays within "
            f"{BAND * math.degrees(size):.2g}° has settled; a larger step or a finer encoder would show it"
        )
    return "a steady load holds the axis off, the loop is too slow for the seconds that it has, or it goes on swinging"


def _over(volts: float, kp: float) -> float:
    """Error [rad] at which a gain [V/rad] gives some volts."""
    return 0.0 if volts <= 0.0 else volts / kp if kp > 0.0 else math.inf
