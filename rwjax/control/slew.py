"""Rest to rest over an angle: what the ideal on-off law does on the real plant, and the fastest slew there."""

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.drive_limits import Limits, check_manoeuvre, fastest_rate, torque_at, turned, turning, usable_rate
from rwjax.control.minimum_time import PIECES, REACHED, Guess, Manoeuvre, Task, minimum_time
from rwjax.control.on_off import OnOff, on_off, on_off_voltage
from rwjax.control.open_loop import Trajectory, command_delay, open_loop, steady_state
from rwjax.control.resistance import resisting_torque
from rwjax.effects.library import BY_NAME
from rwjax.errors import InputError
from rwjax.rig.model import Rig

FINE = 2e-3
"""Longest time step in which the ideal law is held on the plant [s]."""
SAFE = 0.5
"""Share of the axis's friction that the torque left at the end of a slew may have where an inductance keeps it going."""
FRICTIONLESS = 1e-3
"""Share of the motor's torque that may be left at the end where there is no friction."""
MOST_FRICTION = 0.9
"""Share of the motor's torque that friction takes at most in the guess."""

DAY_S = 86_400.0
"""Longest manoeuvre that is looked for [s]."""


class Slew(NamedTuple):
    """A slew from rest to rest.

    Attributes:
        ideal: The on-off law for the torque that the drive has at the wheel's `top` rate.
        top: Wheel rate on which the design counts [rad/s].
        followed: What the plant makes of the ideal law.
        miss: By how much that misses the angle [rad].
        best: Trajectory of least time on the plant; each of its commands is given the `delay` before it acts.
        delay: Delay of the drive [s].
    """

    ideal: OnOff
    top: float
    followed: Trajectory
    miss: float
    best: Trajectory
    delay: float

    @property
    def time(self) -> float:
        """Least time on the plant, from the first command to rest [s]."""
        return float(self.best.time[-1]) + self.delay


def slew(
    rig: Rig, angle: float, limits: Limits, spin: float = 0.0, progress: Callable[[str], None] = lambda text: None
) -> Slew:
    """Slew of a rig's axis from rest to rest.

    Args:
        rig: The rig.
        angle: Angle to turn [rad].
        limits: What the drive gives.
        spin: Wheel rate beforehand [rad/s].
        progress: Hears of what takes long, in words.

    Returns:
        The ideal law with what the plant makes of it, and the trajectory of least time.

    Raises:
        RigError: As `check_manoeuvre` and `command_delay` do.
        InputError: For limits that are not positive, and an angle or a rate that the search does not reach; begins with the argument.
    """
    check_manoeuvre(rig, limits)
    if angle == 0.0 or not np.isfinite(angle):
        raise InputError(f"angle {turned(angle)}: has to be a number other than 0")
    if abs(spin) > fastest_rate(rig, limits):
        raise InputError(f"spin {turning(spin)}: the limits allow {turning(fastest_rate(rig, limits))} at most")
    delay = command_delay(rig, spin)
    top = usable_rate(rig, limits)
    torque = torque_at(rig, limits, top)
    ideal = on_off(rig.values["axis.inertia"], rig.values["wheel.inertia"], angle, torque, top)
    if ideal.time > DAY_S:
        given = ", ".join(
            f"{value:g} {unit}" for value, unit in zip(limits, ("V", "A", "rad/s"), strict=True) if value < np.inf
        )
        what = f"takes {ideal.time:.3g} s at least with limits of {given}; {DAY_S:g} s, a day, at most"
        raise InputError(f"angle {turned(angle)}: {what}")
    progress("following the ideal law on the rig")
    followed = _followed(rig, ideal, float(np.sign(angle)))
    friction = float(np.max(followed.holds[0]))
    structure, theta, start = steady_state(rig, spin)
    commands, seconds = _guess(rig, angle, torque, spin, friction)
    numbers = jnp.array([angle, ideal.time, torque])
    task = Task(theta, limits, numbers, start, seconds, float(np.sign(angle)))
    torque_voltage = torque * rig.values["motor.resistance"] / rig.values["motor.torque_constant"]
    manoeuvre = Manoeuvre(structure, _still if structure.inductive else _arrived, slides_from=1)
    best, missed = minimum_time(manoeuvre, task, Guess(commands, torque_voltage), progress)
    if missed > REACHED:
        raise InputError(_shortfall(rig, angle, limits, spin, best))
    return Slew(ideal, top, followed, float(followed.angle[-1]) - angle, best, delay)


def _shortfall(rig: Rig, angle: float, limits: Limits, spin: float, best: Trajectory) -> str:
    r"""What to say of a slew that was not found.

    The axis has what the wheel gives less what friction of m or more has taken, $I w \le h - m t$, and turns no further than $h^2/(2 I m)$.
    """
    I, J = rig.values["axis.inertia"], rig.values["wheel.inertia"]
    h = J * (fastest_rate(rig, limits) + float(np.sign(angle)) * spin)
    m = float(resisting_torque(rig, abs(angle), h / I, 0.0)[1])
    known = m > 0.0 and not any(BY_NAME[name].changes_over_time for name in rig.effects)
    reach = h**2 / (2.0 * I * m) if known else np.inf
    if abs(angle) > reach:
        why = f"what resists the axis, {m:.3g} N m at least, takes the {h:.3g} N m s that the wheel can give within {np.degrees(reach):.3g}°"
    else:
        ends = np.degrees(float(best.angle[-1]))
        why = f"the search ends at {ends:.3g}°; friction may take the wheel's momentum"
    advice = "turn less far, or spin the wheel the other way beforehand"
    return f"angle {turned(angle)}: is not reached within these limits: {why}; {advice}"


def _followed(rig: Rig, ideal: OnOff, way: float) -> Trajectory:
    """What a rig at rest makes of the ideal law, its axis turned this `way`, 1 or -1."""
    structure, theta, still = steady_state(rig)
    count = int(np.ceil(ideal.time / FINE))
    t = (np.arange(count) + 0.5) * ideal.time / count
    return open_loop(structure, theta, jnp.asarray(-way * on_off_voltage(rig, ideal, t)), ideal.time, still)


def _arrived(found: Trajectory, numbers: Array) -> tuple[Array, Array]:
    """The axis stands at its angle."""
    angle, time, _ = numbers
    return jnp.stack([found.angle[-1] / angle - 1.0, found.rate[-1] * time / angle]), jnp.zeros(0)


def _still(found: Trajectory, numbers: Array) -> tuple[Array, Array]:
    """The axis stands at its angle, and the current that an inductance keeps going does not move it again."""
    torque = numbers[2]
    rest = SAFE * jnp.where(found.holds[-1] > 0.0, found.holds[-1], FRICTIONLESS * torque)
    left = jnp.stack([rest[0] + found.torque[-1], rest[1] - found.torque[-1]]) / torque
    return _arrived(found, numbers)[0], left


def _guess(
    rig: Rig, angle: float, torque: float, spin: float, friction: float
) -> tuple[Float[np.ndarray, " c"], float]:
    """Commands [V] and duration [s] of a slew with constant torque and friction [N m] whose wheel has no limit."""
    K, R = rig.values["motor.torque_constant"], rig.values["motor.resistance"]
    I, J = rig.values["axis.inertia"], rig.values["wheel.inertia"]
    gains, loses = (torque - min(friction, MOST_FRICTION * torque)) / I, (torque + friction) / I
    peak = np.sqrt(2.0 * abs(angle) / (1.0 / gains + 1.0 / loses))
    up, down = peak / gains, peak / loses
    t = np.linspace(0.0, up + down, PIECES + 1)
    push = -np.sign(angle) * torque
    Omega = spin + push / J * (np.minimum(t, up) - np.maximum(t - up, 0.0))
    return np.where(t < up, push, -push) * R / K + K * Omega, up + down
