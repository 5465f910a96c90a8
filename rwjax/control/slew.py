"""Rest to rest over an angle: the ideal on-off law in closed form, what it does on the real plant, and the fastest one there."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.closed_loop import holding
from rwjax.control.open_loop import (
    PIECES,
    REACHED,
    Course,
    Limits,
    Task,
    check,
    course,
    fastest,
    fastest_rate,
    steady,
    torque_at,
    usable_rate,
    waiting,
)
from rwjax.errors import InputError
from rwjax.rig.model import Rig

FINE = 2e-3  # s, longest step in which the ideal law is held on the plant
SAFE = 0.5
"""Share of the axis's friction that the torque left at the end of a slew may have where an inductance keeps it going."""


class OnOff(NamedTuple):
    """The ideal law (thesis eq. 4.2 to 4.6): the wheel speeds up at `acceleration` [rad/s²] for `ramp` [s], keeps `top` [rad/s]
    for `hold` [s] and slows down for `ramp`; `time` [s] of the whole."""

    acceleration: float
    ramp: float
    hold: float
    top: float

    @property
    def time(self) -> float:
        return 2.0 * self.ramp + self.hold

    def wheel(self, t: Float[np.ndarray, " t"]) -> Float[np.ndarray, " t"]:
        """Rate of the wheel [rad/s]."""
        return self.acceleration * np.minimum(np.clip(t, 0.0, self.ramp), np.clip(self.time - t, 0.0, self.ramp))

    def turned(self, t: Float[np.ndarray, " t"]) -> Float[np.ndarray, " t"]:
        """Angle through which the wheel has turned [rad]; the axis turns J/I times as far the other way (eq. 4.2)."""
        up, down = np.clip(t, 0.0, self.ramp), np.clip(t - self.ramp - self.hold, 0.0, self.ramp)
        flat = np.clip(t - self.ramp, 0.0, self.hold + self.ramp)
        return self.acceleration * (0.5 * up**2 + self.ramp * flat - 0.5 * down**2)


def on_off(I: float, J: float, angle: float, torque: float, top: float) -> OnOff:
    r"""Ideal on-off slew over `angle` [rad] of an axis `I` with a wheel `J` [kg m²], a motor torque [N m] and a `top` rate of the
    wheel [rad/s], without friction: $t_1 = J\Omega/\tau$, $t_2 = \theta I/(J\Omega) - t_1$ (eq. 4.3 to 4.6); where that is
    negative the wheel turns round before its top, at $\Omega = \sqrt{\theta I \tau}/J$."""
    size = abs(angle)
    peak = min(top, np.sqrt(size * I * torque) / J)
    ramp = J * peak / torque
    return OnOff(torque / J, ramp, max(size * I / (J * peak) - ramp, 0.0), peak)


def law(rig: Rig, ideal: OnOff, t: Float[np.ndarray, " t"]) -> Float[np.ndarray, " t"]:
    r"""Voltage that makes the wheel follow the ideal law: $V = R\,(J\dot\Omega + b\,\Omega)/K + K\,\Omega$, inductance left out."""
    K, R, J = (rig.values[n] for n in ("motor.torque_constant", "motor.resistance", "wheel.inertia"))
    rising = np.where(
        t < ideal.ramp, 1.0, np.where(t < ideal.ramp + ideal.hold, 0.0, np.where(t < ideal.time, -1.0, 0.0))
    )
    return R / K * J * ideal.acceleration * rising + holding(rig.values) * ideal.wheel(t)


class Slew(NamedTuple):
    """The `ideal` law for the torque that the drive has at the wheel's `top` rate [rad/s], what the plant makes of it (`miss`
    [rad] at its end), and the `best` course of least time on the plant; each of its commands is given the `delay` [s] of the
    drive before it acts."""

    ideal: OnOff
    top: float
    followed: Course
    miss: float
    best: Course
    delay: float

    @property
    def time(self) -> float:
        """Least time on the plant, from the first command to rest [s]."""
        return float(self.best.time[-1]) + self.delay


def slew(rig: Rig, angle: float, limits: Limits, spin: float = 0.0) -> Slew:
    """Slews over `angle` [rad] from rest, the wheel at `spin` [rad/s] beforehand.

    Raises `InputError` for a rig without a wheel, limits that are not positive, an angle that the search does not reach, and as
    `waiting` does.
    """
    check(rig, limits)
    if angle == 0.0 or not np.isfinite(angle):
        raise InputError(f"angle {angle:g} rad: has to be a number other than 0")
    if abs(spin) > fastest_rate(rig, limits):
        raise InputError(f"wheel at {spin:g} rad/s: the limits allow {fastest_rate(rig, limits):g} rad/s")
    delay = waiting(rig, spin)
    top = usable_rate(rig, limits)
    torque = torque_at(rig, limits, top)
    ideal = on_off(rig.values["axis.inertia"], rig.values["wheel.inertia"], angle, torque, top)
    structure, theta, still = steady(rig)
    pieces = int(np.ceil(ideal.time / FINE))
    t = (np.arange(pieces) + 0.5) * ideal.time / pieces
    followed = course(structure, theta, jnp.asarray(-np.sign(angle) * law(rig, ideal, t)), ideal.time, still)

    conditions = _still if structure.inductive else _arrived
    guess, seconds = _guess(rig, angle, torque, spin, float(np.max(followed.holds[0])))
    numbers = jnp.array([angle, ideal.time, torque])
    task = Task(theta, limits, numbers, steady(rig, spin)[2], seconds, float(np.sign(angle)))
    pushes = torque * rig.values["motor.resistance"] / rig.values["motor.torque_constant"]
    best, missed = fastest(structure, conditions, 1, task, guess, pushes)
    if missed > REACHED:
        raise InputError(
            f"{np.degrees(angle):g}° are not reached within these limits (the search ends at "
            f"{np.degrees(float(best.angle[-1])):.3g}°): friction may take the wheel's momentum; "
            "turn less far, or spin the wheel the other way beforehand"
        )
    return Slew(ideal, top, followed, float(followed.angle[-1]) - angle, best, delay)


def _arrived(found: Course, numbers: Array) -> tuple[Array, Array]:
    """The axis stands at its angle."""
    angle, time, _ = numbers
    return jnp.stack([found.angle[-1] / angle - 1.0, found.rate[-1] * time / angle]), jnp.zeros(0)


def _still(found: Course, numbers: Array) -> tuple[Array, Array]:
    """And what current an inductance keeps going does not move it again; without friction there is hardly any."""
    torque = numbers[2]
    rest = SAFE * jnp.where(found.holds[-1] > 0.0, found.holds[-1], 1e-3 * torque)
    left = jnp.stack([rest[0] + found.torque[-1], rest[1] - found.torque[-1]]) / torque
    return _arrived(found, numbers)[0], left


def _guess(
    rig: Rig, angle: float, torque: float, spin: float, friction: float
) -> tuple[Float[np.ndarray, " c"], float]:
    """Commands and duration of a slew with constant torque and friction [N m] whose wheel has no limit."""
    K, R = rig.values["motor.torque_constant"], rig.values["motor.resistance"]
    I, J = rig.values["axis.inertia"], rig.values["wheel.inertia"]
    gains, loses = (torque - min(friction, 0.9 * torque)) / I, (torque + friction) / I
    peak = np.sqrt(2.0 * abs(angle) / (1.0 / gains + 1.0 / loses))
    up, down = peak / gains, peak / loses
    t = np.linspace(0.0, up + down, PIECES + 1)
    push = -np.sign(angle) * torque
    Omega = spin + push / J * (np.minimum(t, up) - np.maximum(t - up, 0.0))
    return np.where(t < up, push, -push) * R / K + K * Omega, up + down
