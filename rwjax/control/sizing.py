"""Which reaction wheel a slew needs: ring wheels, momentum and torque budget, and the limit that binds (thesis chapter 2)."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from rwjax.control.open_loop import Limits, check, resting, torque_at, usable_rate
from rwjax.errors import InputError
from rwjax.rig import Rig

ALUMINIUM = 2700.0  # kg/m3
LIMITS = ("current", "voltage", "wheel rate", "friction")
"""What may bind: the torque that the current or the voltage leaves, the largest rate of the wheel (of the drive's voltage where no
rate was given), and an axis that friction stops before the angle is reached."""


class Ring(NamedTuple):
    """A wheel that is a ring: `outer` and `inner` radius and `thickness` [m], arrays that broadcast; `density` [kg/m³]."""

    outer: Float[np.ndarray, "..."] | float
    inner: Float[np.ndarray, "..."] | float
    thickness: Float[np.ndarray, "..."] | float
    density: float = ALUMINIUM

    @property
    def mass(self) -> Float[np.ndarray, "..."] | float:
        """Mass [kg]: rho pi (R² - r²) d (thesis eq. 2.4 to 2.6)."""
        return self.density * np.pi * (np.square(self.outer) - np.square(self.inner)) * self.thickness

    @property
    def inertia(self) -> Float[np.ndarray, "..."] | float:
        """Moment of inertia [kg m²]: m (R² + r²)/2."""
        return 0.5 * self.mass * (np.square(self.outer) + np.square(self.inner))

    @property
    def thin_inertia(self) -> Float[np.ndarray, "..."] | float:
        """Moment of inertia of thesis eq. 2.7 [kg m²], m R²: as if all mass lay at the rim."""
        return self.mass * np.square(self.outer)


def slew_time(I: float, angle: float, momentum: Float[np.ndarray, "..."] | float) -> Float[np.ndarray, "..."] | float:
    """Time [s] in which a wheel of this momentum [N m s] turns an axis `I` [kg m²] over an angle: 2 I θ/h (thesis eq. 2.3), the
    wheel speeding up half of it and slowing down the other half, no friction."""
    return 2.0 * I * abs(angle) / momentum


class Size(NamedTuple):
    """What wheels `(…)` can do: `momentum` J Ω [N m s] at the top rate and `torque` [N m] that the motor has there; `needs_momentum`
    and `needs_torque` for the wanted time, friction included; `time` [s] of the fastest slew, infinite where the angle is not
    reached; `limit`: index into `LIMITS` of what binds."""

    momentum: Float[np.ndarray, "..."]
    torque: float
    needs_momentum: float
    needs_torque: float
    time: Float[np.ndarray, "..."]
    limit: Int[np.ndarray, "..."]


def size(rig: Rig, inertia: Float[np.ndarray, "..."], angle: float, seconds: float, limits: Limits) -> Size:
    r"""Slews over `angle` [rad] with wheels of these `inertia` [kg m²] on a rig's motor and axis, wanted in `seconds`.

    The motor has its torque at the wheel's top rate throughout, and friction the level $M$ at which the axis breaks loose: both
    are on the safe side. Accelerating at $(\tau - M)/I$ and braking at $(\tau + M)/I$ the wheel turns round at
    $\Omega = \tau t_1/J$; where that is beyond its top it keeps the top and the axis slows down at $M/I$ meanwhile.
    Raises `InputError` as `slew` does.
    """
    check(rig, limits)
    for name, value in (("angle", angle), ("seconds", seconds)):
        if not (value > 0.0 and np.isfinite(value)):
            raise InputError(f"{name} {value:g}: has to be a positive number")
    I, J = rig.values["axis.inertia"], np.asarray(inertia, float)
    M = float(np.max(resting(rig).holds))
    top = usable_rate(rig, limits)
    torque = torque_at(rig, limits, top)
    weak = 0 if torque_at(rig, limits._replace(volts=np.inf), top) <= torque else 1
    needs_torque, needs_momentum = _needed(I, M, angle, seconds)
    if torque <= M:
        never = np.full(J.shape, np.inf)
        return Size(J * top, torque, needs_momentum, needs_torque, never, np.full(J.shape, weak))
    gains, loses, slows = (torque - M) / I, (torque + M) / I, M / I
    peak = np.sqrt(2.0 * angle / (1.0 / gains + 1.0 / loses))
    turns = J * top >= torque * peak / gains  # the wheel has momentum enough to turn round at once
    ramp = J * top / torque
    w = gains * ramp
    a, b, c = (
        0.5 * slows * (slows / loses - 1.0),
        w * (1.0 - slows / loses),
        0.5 * w**2 * (1.0 / gains + 1.0 / loses) - angle,
    )
    inside = b**2 - 4.0 * a * c
    hold = -2.0 * c / (b + np.sqrt(np.where(inside > 0.0, inside, np.nan)))
    reached = ~turns & (inside >= 0.0) & (hold >= 0.0) & (w >= slows * np.nan_to_num(hold))
    time = np.where(turns, peak / gains + peak / loses, np.inf)
    time = np.where(reached, ramp + hold + (w - slows * hold) / loses, time)
    limit = np.where(turns, weak, np.where(reached, 2, 3))
    return Size(J * top, torque, needs_momentum, needs_torque, time, limit)


def _needed(I: float, M: float, angle: float, seconds: float) -> tuple[float, float]:
    r"""Torque and momentum of a slew without hold in a given time: $T^2 = 4 I\theta\tau/(\tau^2 - M^2)$, and the wheel turns
    round after $T(\tau + M)/(2\tau)$."""
    q = 2.0 * I * angle / seconds**2
    torque = q + np.sqrt(q**2 + M**2)
    return torque, 0.5 * seconds * (torque + M)
