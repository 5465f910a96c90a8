"""Which reaction wheel a slew needs: momentum and torque budget, and the limit that binds (thesis, chapter 2)."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from rwjax.control.delays import delays_of
from rwjax.control.drive_limits import Limits, available_torque, check_manoeuvre, turned, usable_rate
from rwjax.control.resistance import resisting_torque
from rwjax.errors import InputError
from rwjax.rig.model import Rig

ROUNDS = 2000
"""Rounds at most in which the torque needed settles where friction grows with it."""
SETTLED = 1e-12
"""Relative change of the torque needed at which it counts as settled."""
LIMITS = ("current", "voltage", "wheel rate", "friction")
"""What may bind: the torque that the current or the voltage leaves, the largest rate of the wheel (`voltage` where that does not reach
the given one), and an axis that friction stops before the angle is reached."""


class WheelBudget(NamedTuple):
    """What wheels can do, and what a slew needs.

    Attributes:
        momentum: Momentum J Ω at the top rate [N m s], `(...)`.
        torque: Torque that the motor has at the top rate [N m].
        needs_momentum: Momentum that the wanted time needs, friction included [N m s].
        needs_torque: Torque that it needs, friction included [N m].
        time: Time of the fastest slew, the drive's delay in it [s], `(...)`; infinite where the angle is not reached.
        limit: Index into `LIMITS` of what binds, `(...)`.
        delay: Delay of the drive [s].
    """

    momentum: Float[np.ndarray, "..."]
    torque: float
    needs_momentum: float
    needs_torque: float
    time: Float[np.ndarray, "..."]
    limit: Int[np.ndarray, "..."]
    delay: float


def size_wheels(
    rig: Rig, inertia: Float[np.ndarray, "..."], angle: float, seconds: float, limits: Limits
) -> WheelBudget:
    r"""Slews with wheels of different inertia on a rig's motor and axis.

    On the safe side throughout. The motor has its torque at the wheel's top rate. What resists the axis, friction and load,
    is the most that it may be on the way, $M$, while the axis is driven, and the least, $m$, while it is braked. Accelerating at
    $(\tau - M)/I$ and braking at $(\tau + m)/I$ the wheel turns round at $\Omega = \tau t_1/J$. Where that is beyond its top rate it
    keeps the top rate, and the axis slows down at $M/I$ meanwhile. A delay of the drive is part of the time.

    Args:
        rig: The rig.
        inertia: Inertia of the wheels [kg m²], `(...)`.
        angle: Angle to turn [rad].
        seconds: Time in which the slew is wanted [s].
        limits: What the drive gives.

    Returns:
        What the wheels can do, and what the wanted time needs.

    Raises:
        InputError: As `check_manoeuvre` and `usable_rate` do, and for an angle or a time that is not positive, or a time
            that is not longer than the drive's delay.
    """
    check_manoeuvre(rig, limits)
    for said, value in ((f"angle {turned(angle)}", angle), (f"seconds {seconds:g}", seconds)):
        if not (value > 0.0 and np.isfinite(value)):
            raise InputError(f"{said}: has to be a positive number")
    delay = float(delays_of(rig).commands[0])
    if seconds <= delay:
        raise InputError(f"seconds {seconds:g}: the drive's delay alone takes {delay:g} s")
    J = np.asarray(inertia, float)
    top = usable_rate(rig, limits)
    torque, by_current = available_torque(rig, limits, top)
    needs_torque, needs_momentum = _needs(rig, angle, seconds - delay)
    time, moves, turns, reached = _fastest(rig, J, angle, torque, top)
    weak, held = (0 if by_current else 1), (2 if top == limits.top else 1)
    limit = np.where(turns | ~moves, weak, np.where(reached, held, 3))
    return WheelBudget(J * top, torque, needs_momentum, needs_torque, time + delay, limit, delay)


def _needs(rig: Rig, angle: float, seconds: float) -> tuple[float, float]:
    """Torque [N m] and momentum [N m s] that a slew needs in a given time [s], friction included."""
    I, torque, momentum = rig.values["axis.inertia"], 0.0, 0.0
    for _ in range(ROUNDS):  # friction may grow with the torque, by less than that
        M, m = resisting_torque(rig, angle, 2.0 * angle / seconds, torque)
        before = torque
        torque, momentum = _needed(I, float(M), float(m), angle, seconds)
        if abs(torque - before) <= SETTLED * torque:
            break
    return torque, momentum


def _needed(I: float, M: float, m: float, angle: float, seconds: float) -> tuple[float, float]:
    r"""Torque and momentum of a slew without hold against constant torques.

    $T^2 = 2 I\theta\,(2\tau + m - M)/((\tau - M)(\tau + m))$, and the wheel turns round after
    $T(\tau + m)/(2\tau + m - M)$.
    """
    q = 2.0 * I * angle / seconds**2
    torque = float(q + 0.5 * (M - m) + np.sqrt(q**2 + 0.25 * (M + m) ** 2))
    return torque, float(torque * seconds * (torque + m) / (2.0 * torque + m - M))


class _Fastest(NamedTuple):
    """Time [s] of the fastest slews without delay, infinite where the angle is not reached.

    Whether the axis `moves` at all, the wheel `turns` round before its top rate, the angle is `reached` with a hold there.
    """

    time: Float[np.ndarray, "..."]
    moves: Bool[np.ndarray, "..."]
    turns: Bool[np.ndarray, "..."]
    reached: Bool[np.ndarray, "..."]


def _fastest(rig: Rig, J: Float[np.ndarray, "..."], angle: float, torque: float, top: float) -> _Fastest:
    """The fastest slews of wheels J [kg m²] with a motor torque [N m] up to a top rate [rad/s]."""
    I = rig.values["axis.inertia"]
    # the axis takes no more than the wheel's momentum, nor what the torque gives it over the whole angle
    fastest = np.minimum(J * top / I, np.sqrt(2.0 * angle * torque / I))
    M, m = resisting_torque(rig, angle, fastest, torque)
    moves = torque > M
    M, m = np.where(moves, M, 0.0), np.where(moves, m, 0.0)
    gains, loses, slows = (torque - M) / I, (torque + m) / I, M / I
    peak = np.sqrt(2.0 * angle / (1.0 / gains + 1.0 / loses))
    turns = moves & (J * top >= torque * peak / gains)  # the wheel has momentum enough to turn round at once
    ramp = J * top / torque
    w = gains * ramp
    # the hold t solves a t² + b t + c = 0
    a = 0.5 * slows * (slows / loses - 1.0)
    b = w * (1.0 - slows / loses)
    c = 0.5 * w**2 * (1.0 / gains + 1.0 / loses) - angle
    inside = b**2 - 4.0 * a * c
    hold = -2.0 * c / (b + np.sqrt(np.where(inside > 0.0, inside, np.nan)))
    reached = moves & ~turns & (inside >= 0.0) & (hold >= 0.0) & (w >= slows * np.nan_to_num(hold))
    time = np.where(turns, peak / gains + peak / loses, np.inf)
    time = np.where(reached, ramp + hold + (w - slows * hold) / loses, time)
    return _Fastest(time, moves, turns, reached)
