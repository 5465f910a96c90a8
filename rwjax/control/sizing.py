"""Which reaction wheel a slew needs: ring wheels, momentum and torque budget, and the limit that binds (thesis chapter 2)."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from rwjax.control.linear import lateness
from rwjax.control.open_loop import Limits, check, push_at, steady, usable_rate
from rwjax.effects.ports import AxisDry, AxisElastic, AxisTorque
from rwjax.errors import InputError
from rwjax.plant.one_axis import Structure, friction_level
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import one_axis_plant_of
from rwjax.types import Scalar

ALUMINIUM = 2700.0  # kg/m3
RATES, ANGLES = 201, 61  # at which friction and load are looked at
ROUNDS = 2000  # at most, in which the torque needed settles where friction grows with it
LIMITS = ("current", "voltage", "wheel rate", "friction")
"""What may bind: the torque that the current or the voltage leaves, the largest rate of the wheel (`voltage` where that does not reach
the given one), and an axis that friction stops before the angle is reached."""


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
    reached, the drive's `delay` [s] in it; `limit`: index into `LIMITS` of what binds."""

    momentum: Float[np.ndarray, "..."]
    torque: float
    needs_momentum: float
    needs_torque: float
    time: Float[np.ndarray, "..."]
    limit: Int[np.ndarray, "..."]
    delay: float


def size(rig: Rig, inertia: Float[np.ndarray, "..."], angle: float, seconds: float, limits: Limits) -> Size:
    r"""Slews over `angle` [rad] with wheels of these `inertia` [kg m²] on a rig's motor and axis, wanted in `seconds`.

    On the safe side throughout: the motor has its torque at the wheel's top rate, and what resists the axis, friction and load,
    is the most that it may be on the way, $M$, while the axis is driven, and the least, $m$, while it is braked. Accelerating at
    $(\tau - M)/I$ and braking at $(\tau + m)/I$ the wheel turns round at $\Omega = \tau t_1/J$; where that is beyond its top it keeps
    the top and the axis slows down at $M/I$ meanwhile. A delay of the drive is part of the time.
    Raises `InputError` as `slew` does.
    """
    check(rig, limits)
    for name, value in (("angle", angle), ("seconds", seconds)):
        if not (value > 0.0 and np.isfinite(value)):
            raise InputError(f"{name} {value:g}: has to be a positive number")
    delay = float(lateness(rig).commands[0])
    if seconds <= delay:
        raise InputError(f"seconds {seconds:g}: the drive's delay alone takes {delay:g} s")
    I, J, seconds = rig.values["axis.inertia"], np.asarray(inertia, float), seconds - delay
    top = usable_rate(rig, limits)
    torque, by_current = push_at(rig, limits, top)
    weak, held = (0 if by_current else 1), (2 if top == limits.top else 1)
    needs_torque, needs_momentum = 0.0, 0.0
    for _ in range(ROUNDS):  # friction may grow with the torque, by less than that
        M, m = resistance(rig, angle, 2.0 * angle / seconds, needs_torque)
        before = needs_torque
        needs_torque, needs_momentum = _needed(I, float(M), float(m), angle, seconds)
        if abs(needs_torque - before) <= 1e-12 * needs_torque:
            break
    # the axis takes no more than the wheel's momentum, nor what the torque gives it over the whole angle
    fastest = np.minimum(J * top / I, np.sqrt(2.0 * angle * torque / I))
    M, m = resistance(rig, angle, fastest, torque)
    moves = torque > M
    M, m = np.where(moves, M, 0.0), np.where(moves, m, 0.0)
    gains, loses, slows = (torque - M) / I, (torque + m) / I, M / I
    peak = np.sqrt(2.0 * angle / (1.0 / gains + 1.0 / loses))
    turns = moves & (J * top >= torque * peak / gains)  # the wheel has momentum enough to turn round at once
    ramp = J * top / torque
    w = gains * ramp
    a, b, c = (
        0.5 * slows * (slows / loses - 1.0),
        w * (1.0 - slows / loses),
        0.5 * w**2 * (1.0 / gains + 1.0 / loses) - angle,
    )
    inside = b**2 - 4.0 * a * c
    hold = -2.0 * c / (b + np.sqrt(np.where(inside > 0.0, inside, np.nan)))
    reached = moves & ~turns & (inside >= 0.0) & (hold >= 0.0) & (w >= slows * np.nan_to_num(hold))
    time = np.where(turns, peak / gains + peak / loses, np.inf)
    time = np.where(reached, ramp + hold + (w - slows * hold) / loses, time)
    limit = np.where(turns | ~moves, weak, np.where(reached, held, 3))
    return Size(J * top, torque, needs_momentum, needs_torque, time + delay, limit, delay)


def _needed(I: float, M: float, m: float, angle: float, seconds: float) -> tuple[float, float]:
    r"""Torque and momentum of a slew without hold in a given time: $T^2 = 2 I\theta\,(2\tau + m - M)/((\tau - M)(\tau + m))$, and the
    wheel turns round after $T(\tau + m)/(2\tau + m - M)$."""
    q = 2.0 * I * angle / seconds**2
    torque = float(q + 0.5 * (M - m) + np.sqrt(q**2 + 0.25 * (M + m) ** 2))
    return torque, float(torque * seconds * (torque + m) / (2.0 * torque + m - M))


def resistance(
    rig: Rig, angle: float, rate: Float[np.ndarray, "..."] | float, drive: float
) -> tuple[np.ndarray, np.ndarray]:
    """Most and least torque [N m] of friction and load against an axis that turns from rest through `angle` [rad], either way, no
    faster than `rate` [rad/s] (…), driven or braked by the torque `drive` [N m]."""
    structure, theta, still = steady(rig)
    rates = np.linspace(0.0, float(np.max(rate)), RATES)
    both = np.asarray(
        _against(structure, theta, still, jnp.linspace(0.0, angle, ANGLES), jnp.asarray(rates), jnp.asarray(drive))
    )
    upto = np.searchsorted(rates, np.asarray(rate) * (1.0 - 1e-12)).clip(max=RATES - 1)
    most, least = np.maximum.accumulate(both.max(axis=(0, 2))), np.minimum.accumulate(both.min(axis=(0, 2)))
    return np.asarray(most[upto]), np.asarray(least[upto])


@partial(jax.jit, static_argnums=0)
def _against(
    structure: Structure,
    theta: Float[Array, " p"],
    still: Float[Array, " n"],
    angles: Float[Array, " a"],
    rates: Float[Array, " r"],
    drive: Scalar,
) -> Float[Array, "2 r a"]:
    """Torque against the axis forward and backward."""
    plant, zero = one_axis_plant_of(structure, theta), jnp.zeros(())
    dry = [effect for effect in plant.effects if isinstance(effect, AxisDry | AxisElastic)]
    smooth = [effect for effect in plant.effects if isinstance(effect, AxisTorque)]
    psi, w = (structure.states.index(name) for name in ("psi", "w"))

    def one(way: float, turned: Scalar, rate: Scalar) -> Scalar:
        m = plant.motion(zero, tuple(still.at[psi].set(way * turned).at[w].set(way * rate)), zero)
        torque = sum((effect.torque(m) for effect in smooth), start=zero)
        return friction_level(dry, m._replace(load=drive), way) - way * torque

    ways = [jax.vmap(jax.vmap(partial(one, way), (0, None)), (None, 0))(angles, rates) for way in (1.0, -1.0)]
    return jnp.stack(ways)
