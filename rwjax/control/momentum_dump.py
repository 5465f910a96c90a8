"""Momentum dump: the wheel slows while static friction holds the axis, and its momentum leaves through the bearing."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.controller import wheel_holding_voltage
from rwjax.control.drive_limits import Limits, check_manoeuvre, torque_at, turning
from rwjax.control.minimum_time import PIECES, REACHED, STEPS, Guess, Manoeuvre, Task, least_in_pieces, minimum_time
from rwjax.control.open_loop import Trajectory, at_rest, command_delay, steady_state
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import AxisDry, AxisElastic
from rwjax.errors import InputError, RigError
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.dry_friction import friction_level
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig

MARGIN = 0.9
"""Share of the breakaway torque that a dump uses."""
SPARE = 0.95
"""Share of the torque that friction or the drive bear with which the search begins."""
LEAST_TORQUE = 1e-2
"""Least torque with which the search begins, over what friction holds."""


class Dump(NamedTuple):
    """A momentum dump.

    Attributes:
        bound: Time below which no command does it [s]; 0 where no bound is known.
        best: Trajectory of least time; each of its commands is given the `delay` before it acts.
        delay: Delay of the drive [s].
    """

    bound: float
    best: Trajectory
    delay: float

    @property
    def time(self) -> float:
        """Least time on the plant, from the first command to rest [s]."""
        return float(self.best.time[-1]) + self.delay


def dump(
    rig: Rig, spin: float, limits: Limits, margin: float = MARGIN, progress: Callable[[str], None] = lambda text: None
) -> Dump:
    r"""Brings the wheel to rest in the least time in which the axis does not move.

    While the axis rests, what turns the wheel pushes back on the axis: $|J\dot\Omega| \le T = (\mu M_s - M_l)/(1 - \mu\,\mu_l)$. No dump
    is shorter than $J\Omega_0/T$. Here $\mu$ is the `margin`; $M_s + \mu_l T$ is the breakaway torque, of which $\mu_l T$ grows with
    the torque; $M_l$ is the load that the axis bears. Where friction or load change over time, no such bound is known.

    Args:
        rig: The rig.
        spin: Wheel rate at the beginning [rad/s].
        limits: What the drive gives.
        margin: Share of the breakaway torque that is used [1].
        progress: Hears of what takes long, in words.

    Returns:
        The bound, and the trajectory of least time.

    Raises:
        RigError: As `check_manoeuvre` and `command_delay` do, and for an axis that friction does not hold or holds only after it
            has moved a little.
        InputError: For a rate, a margin or limits that cannot be, and a dump that is not found; begins with the argument.
    """
    check_manoeuvre(rig, limits)
    if spin == 0.0 or not np.isfinite(spin):
        raise InputError(f"spin {turning(spin)}: has to be a number other than 0")
    if not 0.0 < margin <= 1.0:
        raise InputError(f"margin {margin:g}: has to lie above 0 and not above 1")
    if elastic := [name for name in rig.effects if issubclass(BY_NAME[name], AxisElastic)]:
        raise RigError(f"`{elastic[0]}`: the axis moves a little before it is held; leave it out")
    progress("looking at what friction holds")
    room, held = _holding_torque(rig, spin, margin)
    changes = any(BY_NAME[name].changes_over_time for name in rig.effects)
    delay = command_delay(rig, spin)
    bound = 0.0 if changes else rig.values["wheel.inertia"] * abs(spin) / room + delay
    best, missed = _search(rig, spin, limits, margin, _torque(rig, spin, limits, room, held), progress)
    if missed > REACHED:
        raise InputError(_shortfall(best, spin, -torque_at(rig, limits, abs(spin)), room))
    return Dump(bound, best, delay)


def _holding_torque(rig: Rig, spin: float, margin: float) -> tuple[float, float]:
    """Torque [N m] with which the wheel may slow, the load taken off, and what friction holds at rest."""
    structure, theta, _ = steady_state(rig, spin)
    before, way = at_rest(rig), float(np.sign(spin))
    load, held = way * float(before.torque), margin * float(before.holds[1 if spin > 0.0 else 0])
    room = held - load
    if room <= 0.0:
        raise RigError("nothing holds the axis while the wheel slows: the rig has no dry friction left for it")
    left = 1.0 - margin * float(_growth(structure, theta, way))
    return (room / left if left > 0.0 else np.inf), held  # friction that grows as fast as what it holds


@partial(jax.jit, static_argnums=(0, 2))
def _growth(structure: Structure, theta: Float[Array, " p"], way: float) -> Array:
    """By how much the axis's breakaway torque grows with the torque of the drive [1]."""
    plant, zero = one_axis_plant_of(structure, theta), jnp.zeros(())
    rest = plant.motion(zero, tuple(zero for _ in structure.states), zero)
    none, one = (friction_level(plant.on(AxisDry), rest._replace(load=jnp.asarray(x)), way) for x in (0.0, 1.0))
    return one - none


def _torque(rig: Rig, spin: float, limits: Limits, room: float, held: float) -> float:
    """Torque [N m] of the dump with which the search begins."""
    K, R = rig.values["motor.torque_constant"], rig.values["motor.resistance"]
    ripple = K**2 * abs(spin) / (2 * PIECES * STEPS * R)  # of a command that is held while the wheel slows over a step
    return SPARE * min(room / (1.0 + ripple / room), max(torque_at(rig, limits, 0.0), LEAST_TORQUE * held))


def _search(
    rig: Rig, spin: float, limits: Limits, margin: float, torque: float, progress: Callable[[str], None]
) -> tuple[Trajectory, float]:
    """The dump of least time, and how far it violates its conditions, from one with a constant torque [N m]."""
    structure, theta, start = steady_state(rig, spin)
    K, R, J = (rig.values[n] for n in ("motor.torque_constant", "motor.resistance", "wheel.inertia"))
    Omega = spin * np.linspace(1.0, 0.0, PIECES + 1)
    torque_voltage = R / K * torque
    commands = float(wheel_holding_voltage(rig.values)) * Omega - float(np.sign(spin)) * torque_voltage
    numbers = jnp.array([spin, K / torque, margin, torque])
    task = Task(theta, limits, numbers, start, J * abs(spin) / torque, 1.0)
    manoeuvre = Manoeuvre(structure, _stopped if structure.inductive else _slowed, slides_from=PIECES)
    return minimum_time(manoeuvre, task, Guess(commands, torque_voltage), progress)


def _shortfall(best: Trajectory, spin: float, brakes: float, room: float) -> str:
    """What to say of a dump that was not found: that the drive `brakes` more than friction has `room` for [N m], or what the best lacks."""
    if brakes > room:
        return (
            f"spin {turning(spin)}: no dump was found: at this rate the back-EMF brakes with {brakes:.3g} N m whatever the voltage does, and "
            f"static friction bears {room:.3g} N m; begin at a lower rate of the wheel, or raise the voltage"
        )
    left, moved = abs(float(best.wheel[-1]) / spin), float(np.max(np.abs(best.angle)))
    what = f"the axis moves by {np.degrees(moved):.2g}°; begin at a lower rate of the wheel" if moved > 0.0 else ""
    slow = f"{100.0 * left:.2g} % of the rate are left; raise the voltage or the current" if left > REACHED else ""
    tight = (
        "static friction is used beyond its share, or voltage or current beyond theirs; use a larger share of the first"
    )
    return f"spin {turning(spin)}: no dump was found: {what or slow or tight}"


def _slowed(found: Trajectory, numbers: Array) -> tuple[Array, Array]:
    """The wheel stands, and friction held the axis all the while."""
    spin, _, margin, room = numbers
    within = (margin * found.holds[:, 0] + found.torque, margin * found.holds[:, 1] - found.torque)
    return found.wheel[-1:] / spin, jnp.concatenate([least_in_pieces(w / room) for w in within])


def _stopped(found: Trajectory, numbers: Array) -> tuple[Array, Array]:
    """The wheel stands, and no current is left that would turn it again."""
    zero, positive = _slowed(found, numbers)
    return jnp.append(zero, numbers[1] * found.current[-1]), positive
