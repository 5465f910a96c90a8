"""Free runs: whole logs simulated from their first state by their commands alone."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from rwjax.plant.plant import Plant
from rwjax.plant.structure import Structure
from rwjax.simulation.batch import Batch
from rwjax.simulation.commands import commands
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.simulation.program_cache import stored
from rwjax.simulation.reading import Slots, readings
from rwjax.simulation.stepper import Stepper
from rwjax.simulation.windows import plant_of_run, prepare, side_by_side, time_grid


@stored(tuple)
def free_run(
    structure: Structure,
    theta: Float[Any, " t"],
    start: Float[Any, "l n"],
    batch: Batch,
    *,
    stepper: Stepper = EXPONENTIAL_STEP,
) -> Any:
    """Readings of whole logs from their first state, and the states at the windows' starts.

    Args:
        structure: What the plant is made of.
        theta: Numbers of all logs `(t,)` [SI].
        start: First state of every log `(l, n)` [SI].
        batch: The logs.
        stepper: What moves the plant over one step.

    Returns:
        Readings `(l, w, q, y)` [rad, rad/s or A] and states `(l, w, n)` [SI].
    """
    return side_by_side(lambda run, x0: _whole(structure, stepper, theta, run, x0), batch, start)


@stored(lambda found: found[0])
def free_runs(
    structure: Structure,
    theta: Float[Any, "l t"],
    start: Float[Any, "l n"],
    windows: Int[Any, ""],
    batch: Batch,
    *,
    stepper: Stepper = EXPONENTIAL_STEP,
) -> Any:
    """Readings of the first windows of logs from their first state, every log with numbers of its own.

    Args:
        structure: What the plant is made of.
        theta: Numbers `(l, t)` for each log [SI].
        start: First state of every log `(l, n)` [SI].
        windows: How many windows to simulate [1].
        batch: The logs.
        stepper: What moves the plant over one step.

    Returns:
        Readings `(l, w, q, y)` [rad, rad/s or A]; those of later windows are 0.
    """
    return [
        side_by_side(lambda run, x0, theta: _first(structure, stepper, theta, run, x0, windows), batch, start, theta)
    ]


def _window_by_window(plant: Plant, stepper: Stepper, run: Batch) -> tuple[Callable, tuple]:
    """What goes through a window, from its first state and its inputs, to its end; and the inputs of all windows."""
    h, t0 = time_grid(plant, run)
    moved = prepare(plant, stepper, h)
    steps, at_reading = commands(plant, run)
    W, m = run.slot_step.shape[0], run.step_index.shape[0]

    def window(x: Float[Array, " n"], inputs: tuple) -> tuple[Float[Array, " n"], tuple[Array, Array]]:
        w, u, *slots = inputs
        begin = t0 + w * m * h
        states = moved.states(begin, x, u)
        y = readings(plant, h, begin, states, Slots(*slots))
        return jnp.stack([s[-1] for s in states]), (y, x)

    slots = jnp.asarray(run.slot_step), jnp.asarray(run.slot_part)
    return window, (jnp.arange(W, dtype=float), steps.reshape(W, m, *steps.shape[1:]), at_reading, *slots)


def _with_late_readings(plant: Plant, stepper: Stepper, run: Batch, x0: Float[Array, " n"]) -> tuple[Array, Array]:
    """Readings of one log, each of which may show another window, and the states at its windows' starts."""
    h, t0 = time_grid(plant, run)
    steps, at_reading = commands(plant, run)
    slot_step, slot_part = jnp.asarray(run.slot_step), jnp.asarray(run.slot_part)
    W, m = slot_step.shape[0], run.step_index.shape[0]
    states = prepare(plant, stepper, h).states(t0, x0, steps)
    at = (m * jnp.arange(W)[:, None] + slot_step).ravel()
    slots = Slots(at_reading.reshape(at.size, *at_reading.shape[2:]), at, slot_part.ravel())
    y = readings(plant, h, t0, states, slots)
    return y.reshape(W, -1, y.shape[-1]), jnp.stack([s[: W * m : m] for s in states], axis=-1)


def _whole(
    structure: Structure, stepper: Stepper, theta: Float[Array, " t"], run: Batch, x0: Float[Array, " n"]
) -> tuple[Array, Array]:
    """Readings of one log and the states at its windows' starts."""
    plant = plant_of_run(structure, theta, run)
    if plant.age() is not None:
        return _with_late_readings(plant, stepper, run, x0)
    window, inputs = _window_by_window(plant, stepper, run)
    return jax.lax.scan(window, x0, inputs)[1]


def _first(
    structure: Structure,
    stepper: Stepper,
    theta: Float[Array, " t"],
    run: Batch,
    x0: Float[Array, " n"],
    windows: Int[Array, ""],
) -> Array:
    """Readings of one log in its first windows."""
    plant = plant_of_run(structure, theta, run)
    if plant.age() is not None:
        return _with_late_readings(plant, stepper, run, x0)[0]
    window, inputs = _window_by_window(plant, stepper, run)

    def one(w: Int[Array, ""], carry: tuple[Array, Array]) -> tuple[Array, Array]:
        x, y = carry
        x, (seen, _) = window(x, tuple(a[w] for a in inputs))
        return x, y.at[w].set(seen)

    W, q = run.slot_step.shape
    nothing = jnp.zeros((W, q, len(structure.outputs)))
    return jax.lax.fori_loop(0, windows, one, (x0, nothing))[1]
