"""The plant without feedback: trajectories under given commands, and a rig at rest with a steady wheel.

The plant is the nonlinear one, stick and slip included.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.delays import delays_of
from rwjax.control.steady_wheel import steady_wheel
from rwjax.effects.library import BY_NAME
from rwjax.errors import RigError
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.dry_friction import friction_level
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.types import Scalar

STILL = 1e-9
"""Angle [rad], and share of the wheel's rate, within which nothing moves."""
DELAY_STEPS = 300
"""Time steps in which the drive's delay is looked at."""
INSTANT = 1e-3
"""Time [s] over which a rig at rest is looked at."""


class Trajectory(NamedTuple):
    """What a manoeuvre does, at its times.

    Attributes:
        time: Time [s], `(t,)`.
        angle: Angle of the axis [rad], `(t,)`.
        rate: Rate of the axis [rad/s], `(t,)`.
        wheel: Wheel rate [rad/s], `(t,)`.
        current: Motor current [A], `(t,)`.
        torque: Torque on the axis besides its dry friction [N m], `(t,)`.
        holds: Torque up to which dry friction holds an axis at rest [N m], backward and forward, `(t, 2)`.
        command: Command that comes next [V], `(t,)`.
    """

    time: Float[Array, " t"]
    angle: Float[Array, " t"]
    rate: Float[Array, " t"]
    wheel: Float[Array, " t"]
    current: Float[Array, " t"]
    torque: Float[Array, " t"]
    holds: Float[Array, "t 2"]
    command: Float[Array, " t"]


class Sliding(NamedTuple):
    """From when on an axis is taken to slide, which has derivatives where stick has none.

    Attributes:
        begin: Time step from which on it slides [1].
        way: Direction in which it slides [1], 1 or -1.
    """

    begin: int
    way: Scalar


@partial(jax.jit, static_argnums=0)
def open_loop(
    structure: Structure,
    theta: Float[Array, " p"],
    commands: Float[Array, " c"],
    duration: Scalar | float,
    start: Float[Array, " n"],
) -> Trajectory:
    """What the plant does under commands that are held over equal time steps.

    Args:
        structure: Structure of the plant.
        theta: Parameter vector of that structure, `(p,)` [SI].
        commands: Command of every time step [V], `(c,)`.
        duration: Duration of them all [s].
        start: First state in the structure's order, `(n,)` [SI].

    Returns:
        The trajectory at the beginning of each time step and at the end, `(c + 1,)`.
    """
    return trajectory(structure, theta, commands, duration, start, Sliding(len(commands), jnp.ones(())))


def trajectory(
    structure: Structure,
    theta: Float[Array, " p"],
    commands: Float[Array, " c"],
    duration: Scalar | float,
    start: Float[Array, " n"],
    sliding: Sliding,
) -> Trajectory:
    """`open_loop` of an axis that is taken to slide from some time step on.

    Args:
        structure: Structure of the plant.
        theta: Parameter vector of that structure, `(p,)` [SI].
        commands: Command of every time step [V], `(c,)`.
        duration: Duration of them all [s].
        start: First state in the structure's order, `(n,)` [SI].
        sliding: From when on the axis slides, and which way.

    Returns:
        The trajectory at the beginning of each time step and at the end, `(c + 1,)`.
    """
    plant = one_axis_plant_of(structure, theta)
    h = jnp.asarray(duration) / len(commands)
    p = EXPONENTIAL_STEP.prepare(plant, h)

    def moved(by: Callable) -> Callable:
        def one(carry: tuple, u: Scalar) -> tuple[tuple, Trajectory]:
            t, x = carry
            return (t + h, by(plant, p, t, x, plant.act(u), h)), _instant(plant, t, x, u)

        return one

    first = (jnp.zeros(()), tuple(start[k] for k in range(len(structure.states))))
    middle, sticks = jax.lax.scan(moved(EXPONENTIAL_STEP.step), first, commands[: sliding.begin])
    slides = partial(EXPONENTIAL_STEP.slide, direction=sliding.way)
    (t, x), slid = jax.lax.scan(moved(slides), middle, commands[sliding.begin :])
    last = _instant(plant, t, x, commands[-1])
    return Trajectory(*(jnp.concatenate([a, b, c[None]]) for a, b, c in zip(sticks, slid, last, strict=True)))


def _instant(plant: OneAxis, t: Scalar, x: tuple, u: Scalar) -> Trajectory:
    """One instant of a trajectory, state and command given."""
    volts = plant.act(u)
    m = plant.motion(t, x, volts)
    bodies = plant.bodies()
    torques = plant.with_friction(t, x, volts, x).torques
    dry = [k for k, (body, _) in enumerate(bodies) if body.rate == plant.structure.states.index("w")]
    if dry:
        torque, effects = torques[dry[0]][0], bodies[dry[0]][1]
        holds = jnp.stack([friction_level(effects, m, -1.0), friction_level(effects, m, 1.0)])
    else:
        rate = plant.field(t, x, volts)[plant.structure.states.index("w")]
        torque, holds = rate * plant.whole_inertia(), jnp.zeros(2)
    return Trajectory(t, m.psi, m.w, m.Omega, m.i, torque, holds, u)


def steady_state(rig: Rig, spin: float = 0.0) -> tuple[Structure, Float[Array, " p"], Float[Array, " n"]]:
    """A rig whose axis rests while its wheel turns steadily, as `steady_wheel` has it.

    Args:
        rig: The rig.
        spin: Wheel rate [rad/s].

    Returns:
        Structure of its plant, parameter vector `(p,)` [SI] and state `(n,)` [SI].

    Raises:
        RigError: As `steady_wheel` does.
    """
    structure, theta, state, _ = steady_wheel(rig, spin)
    return structure, theta, state


def at_rest(rig: Rig, spin: float = 0.0) -> Trajectory:
    """The first instant of a rig whose axis rests while its wheel turns steadily.

    Args:
        rig: The rig.
        spin: Wheel rate [rad/s].

    Returns:
        That instant: torque of the load [N m], and what friction holds [N m].

    Raises:
        RigError: As `steady_wheel` does.
    """
    structure, theta, start, keeps = steady_wheel(rig, spin)
    return Trajectory(*(x[0] for x in open_loop(structure, theta, jnp.array([keeps]), INSTANT, start)))


def command_delay(rig: Rig, spin: float = 0.0) -> float:
    """The drive's delay [s], of a rig that waits for its first command as it is at its beginning.

    It rests, under a command that keeps the rate of its wheel.

    Args:
        rig: The rig.
        spin: Wheel rate [rad/s].

    Returns:
        The delay [s].

    Raises:
        RigError: For a rig with a delay that does not wait: its load or its drive moves it meanwhile, its wheel changes its
            rate, or an effect changes with time; and as `steady_wheel` does.
    """
    delay = float(delays_of(rig).commands[0])
    if delay == 0.0:
        return delay
    why = next((f"`{name}` changes with time" for name in rig.effects if BY_NAME[name].changes_over_time), "")
    if not why:
        structure, theta, start, keeps = steady_wheel(rig, spin)
        seen = open_loop(structure, theta, jnp.full(DELAY_STEPS, keeps), delay, start)
        if not np.max(np.abs(seen.angle)) <= STILL:
            why = "the axis turns"
        elif not np.max(np.abs(seen.wheel - spin)) <= STILL * max(abs(spin), 1.0):
            why = "the wheel changes its rate"
    if why:
        raise RigError(
            f"{why} before the first command acts, after the drive's delay of {delay:g} s; leave the delay out"
        )
    return delay
