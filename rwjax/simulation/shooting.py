"""Simulation of laid-out logs: windows side by side, their sensitivities, and free runs."""

from functools import partial
from typing import Any, NamedTuple

import rwjax.setup_jax  # noqa: F401  (float64 and the compilation cache come first)

import jax  # isort: skip
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from rwjax.plant.assemble import AnyPlant, assemble
from rwjax.plant.one_axis import Plant, Structure, one_axis
from rwjax.plant.two_axis import TwoAxis
from rwjax.simulation.batch import ALIKE, Batch
from rwjax.simulation.program_cache import stored
from rwjax.simulation.step import propagator, step, with_friction
from rwjax.types import Scalar


class Evaluation(NamedTuple):
    """Residuals of all windows and what a Gauss-Newton step needs. Axes as in `Batch`; `k` numbers, `n` states.

    `residual` (measured - simulated is minus this) in units of noise; `local` its derivative by (numbers, the window's
    first state); `chain`, `shift`: linearised continuity makes the change of a window's first state
    `chain @ (d numbers, d first state of the log) + shift`; `H`, `g`: normal equations of each log with the windows'
    states eliminated; `defect`: end of a window minus start of the next.
    """

    residual: Float[Any, "l w q y"]
    local: Float[Any, "k+n l w q y"]
    chain: Float[Any, "l w n k+n"]
    shift: Float[Any, "l w n"]
    H: Float[Any, "l k+n k+n"]
    g: Float[Any, "l k+n"]
    defect: Float[Any, "l w n"]


def plant_of(structure: Structure, theta: Float[Array, " p"]) -> AnyPlant:
    """Plant with the numbers of the parameter vector, in the order of `structure.names`."""
    return assemble(structure, {name: theta[k] for k, name in enumerate(structure.names)})


def one_axis_plant_of(structure: Structure, theta: Float[Array, " p"]) -> Plant:
    """`plant_of` for a rig with one axis or none."""
    return one_axis(structure, {name: theta[k] for k, name in enumerate(structure.names)})


def _plant_of_run(structure: Structure, theta: Float[Array, " t"], run: Batch) -> AnyPlant:
    """Plant with the numbers of one log: its own entries of `theta`, and what is known to be added to them."""
    return plant_of(structure, theta[jnp.asarray(run.theta_index)] + jnp.asarray(run.theta_offset))


def commands(plant: AnyPlant, run: Batch) -> tuple[Float[Array, "s *channels"], Float[Array, "w q *channels"]]:
    """Mean of the acting command over every grid step of one log and its last window's overlap, and the command at every
    reading [V]."""
    if not isinstance(plant, TwoAxis):
        return _acting(plant, run, plant.pace())
    channels = (run._replace(u_command=run.u_command[:, k]) for k in range(2))
    found = [_acting(half, one, plant.pace()) for half, one in zip(plant.halves, channels, strict=True)]
    steps, readings = (jnp.stack(each, axis=-1) for each in zip(*found, strict=True))
    return steps, readings


def _acting(plant: Plant, run: Batch, pace: Scalar | float) -> tuple[Float[Array, " s"], Float[Array, "w q"]]:
    """`commands` of one channel.

    A delay shifts them in time, continuously: a reading sees the mean from its own time to the next sample or over one
    grid step, whichever is shorter.
    """
    t, h, slot_step = jnp.asarray(run.t_command), jnp.asarray(run.h), jnp.asarray(run.slot_step)
    W, m = slot_step.shape[0], run.step_index.shape[0]
    u = jax.vmap(plant.act)(jnp.asarray(run.u_command))
    delay = plant.delay()
    area = jnp.concatenate([jnp.zeros(1), jnp.cumsum(u * jnp.diff(t))])

    held = jnp.asarray(run.held)
    early = held.shape[0] - (W * m + len(run.late_index) + 1)

    def until(time: Float[Array, " s"], point: Int[Array, " s"], between: bool) -> Float[Array, " s"]:
        """Area of the command up to some times, given the grid points before them."""
        i = held[point + early]
        for _ in run.crowd if between else ():
            i = jnp.where(t[i + 1] <= time, i + 1, i)
        return area[i] + u[i] * (time - t[i])  # the first command is taken to have been held before the log

    def acting(time: Float[Array, " s"], point: Int[Array, " s"], between: bool) -> Float[Array, " s"]:
        if delay is None:
            return until(time, point, between)
        late = time - delay
        return until(late, jnp.clip(jnp.floor(late / h).astype(int), -early, held.shape[0] - early - 1), True)

    grid = jnp.arange(W * m + len(run.late_index) + 1)
    steps = plant.follow(jnp.diff(acting(h * grid.astype(float), grid, False)) / h, h * pace)
    point = (m * jnp.arange(W)[:, None] + slot_step).ravel()
    sample = h * (point.astype(float) + jnp.asarray(run.slot_part).ravel())
    width = jnp.minimum(h, jnp.min(jnp.diff(t)))
    end = jnp.floor((sample + width) / h).astype(int)
    readings = (acting(sample + width, end, True) - acting(sample, point, True)) / width
    if plant.filters:  # what follows slowly has no leaps between steps
        readings = steps[point]
    return steps, readings.reshape(W, -1)


def _one_log(one, batch: Batch):
    """`one(run, *values)` with the indices of steps, which have no axis of logs, put back into `run`; and the batch without them."""
    shared = {name: jnp.asarray(getattr(batch, name)) for name in ALIKE}
    runs = jax.tree.map(jnp.asarray, batch._replace(**dict.fromkeys(ALIKE, batch.h)))
    return (lambda run, *values: one(run._replace(**shared), *values)), runs


def _side_by_side(one, batch: Batch, *of_log: Array):
    """`one(run, *values)` for every log of a batch."""
    each, runs = _one_log(one, batch)
    return jax.vmap(each)(runs, *of_log)


def _log_by_log(one, batch: Batch, *of_log: Array):
    """The same one after the other: of windows and derivatives side by side, those of one log stay in a processor's nearest
    cache."""
    each, runs = _one_log(one, batch)
    return jax.lax.map(lambda values: each(*values), (runs, *of_log))


def _window(plant: AnyPlant, p, h: Scalar, t0: Scalar, x0: Float[Array, " n"], u: Float[Array, "m *channels"]):
    """States at the grid points of one window, as a tuple of arrays of length m + 1."""

    def body(carry, u_k):
        t, x = carry
        return (t + h, step(plant, p, t, x, u_k, h)), x

    n = x0.shape[0]
    (_, end), states = jax.lax.scan(body, (t0, tuple(x0[k] for k in range(n))), u)
    return tuple(jnp.concatenate([s, e[None]]) for s, e in zip(states, end, strict=True))


def _turning(plant: AnyPlant) -> list[tuple[int, int]]:
    """Indices of each angle and its rate among the states."""
    names = plant.structure.states
    return [(names.index(angle), names.index(rate)) for angle, rate, *_ in plant.structure.turning]


def _between(plant: AnyPlant, h: Scalar, states, step, part) -> tuple:
    """States at a part of these grid steps."""
    left, right = tuple(s[step] for s in states), tuple(s[step + 1] for s in states)
    x = [a + part * (b - a) for a, b in zip(left, right, strict=True)]
    for angle, rate in _turning(plant):  # curvature of the angle from the change of its rate
        x[angle] -= 0.5 * part * (1.0 - part) * h * (right[rate] - left[rate])
    return tuple(x)


def _earlier(plant: AnyPlant, h: Scalar, states, step, part, age: Scalar) -> tuple:
    """States a time `age` before a part of these grid steps; before the first grid point every angle goes at its rate there."""
    position = part - age / h
    whole = jnp.floor(position)
    before = jnp.minimum(step.astype(float) + position, 0.0)
    step = step + whole.astype(step.dtype)
    x = list(_between(plant, h, states, jnp.maximum(step, 0), jnp.where(step < 0, 0.0, position - whole)))
    for angle, rate in _turning(plant):
        x[angle] += h * before * x[rate]
    return tuple(x)


def _readings(plant: AnyPlant, h: Scalar, t0: Scalar, states, u, slot_step, slot_part) -> Float[Array, "q y"]:
    """Outputs at the reading slots, interpolated between the grid points of `states`; `u` (q,) the command there."""
    x, age = _between(plant, h, states, slot_step, slot_part), plant.age()
    seen = x if age is None else _earlier(plant, h, states, slot_step, slot_part, age)
    t = t0 + h * (slot_step.astype(float) + slot_part)
    return jnp.stack(jax.vmap(plant.outputs)(t, x, u, seen), axis=-1)


def _simulate_windows(structure: Structure, theta, nodes: Float[Array, "l w n"], batch: Batch):
    """Readings of every window from its own first state, and the state at its end."""

    def one_log(run: Batch, nodes: Float[Array, "w n"]):
        plant = _plant_of_run(structure, theta, run)
        h, t0 = jnp.asarray(run.h) * plant.pace(), jnp.asarray(run.t0) * plant.pace()
        p = propagator(plant, h)
        steps, at_reading = commands(plant, run)
        W, m = run.slot_step.shape[0], run.step_index.shape[0]
        u = steps[np.add.outer(m * np.arange(W), np.arange(m + len(run.late_index)))]

        def one_window(w, x0, u, at_reading, slot_step, slot_part):
            start = t0 + w * m * h
            states = _window(plant, p, h, start, x0, u)
            y = _readings(plant, h, start, states, at_reading, slot_step, slot_part)
            return y, jnp.stack([s[m] for s in states])

        return jax.vmap(one_window)(
            jnp.arange(W, dtype=float), nodes, u, at_reading, jnp.asarray(run.slot_step), jnp.asarray(run.slot_part)
        )

    through = _log_by_log if jax.default_backend() == "cpu" else _side_by_side
    return through(one_log, batch, nodes)


@partial(jax.jit, static_argnames="structure")
def rates_along(
    structure: Structure,
    theta: Float[Array, " p"],
    t: Float[Array, " t"],
    states: Float[Array, "t n"],
    command: Float[Array, "t *channels"],
) -> Float[Array, "t n"]:
    """Rates of all states, dry friction included, along a given motion; a body at speed 0 feels what would hold it."""
    plant = plant_of(structure, theta)

    def one(t: Scalar, x: Float[Array, " n"], u: Float[Array, "*channels"]) -> Float[Array, " n"]:
        state = tuple(x[k] for k in range(len(structure.states)))
        return jnp.stack(with_friction(plant, t, state, plant.act(u), state)[0])

    return jax.vmap(one)(t, states, command)


@stored(Evaluation._make)
def evaluate(
    structure: Structure,
    theta: Float[Any, " t"],
    numbers: Int[Any, " k"],
    nodes: Float[Any, "l w n"],
    batch: Batch,
) -> Evaluation:
    """Residuals and normal equations at `theta` with every window started from its node (condensed multiple shooting).

    `numbers`: which entries of `theta` to differentiate by; an index past its end gives a column of zeros. Bock and
    Plitt (1984); the windows' states are eliminated by linearised continuity, so that the step is that of the whole log
    while every window is short and all of them run side by side. Forward sensitivities, exact to rounding.
    """

    def outcome(theta, nodes):
        y, end = _simulate_windows(structure, theta, nodes, batch)
        return (y - jnp.asarray(batch.reading)) * jnp.asarray(batch.weight), end

    k, (L, W, n) = numbers.shape[0], nodes.shape
    by_number = jnp.concatenate([jax.nn.one_hot(numbers, theta.shape[0]), jnp.zeros((n, theta.shape[0]))])
    by_state = jnp.concatenate([jnp.zeros((k, n)), jnp.eye(n)])
    tangents = (by_number, jnp.broadcast_to(by_state[:, None, None], (k + n, L, W, n)))
    (residual, end), (local, d_end) = jax.vmap(lambda d: jax.jvp(outcome, (theta, nodes), d), out_axes=(None, 0))(
        tangents
    )
    d_end = jnp.moveaxis(d_end, 0, -1)
    defect = (end - jnp.concatenate([nodes[:, 1:], end[:, -1:]], axis=1)).at[:, -1].set(0.0)

    def link(carry, window):
        chain, shift = carry
        d_end, defect = window
        by_theta = jnp.concatenate([d_end[:, :k], jnp.zeros((n, n))], axis=1)
        return (d_end[:, k:] @ chain + by_theta, d_end[:, k:] @ shift + defect), (chain, shift)

    first = (jnp.concatenate([jnp.zeros((n, k)), jnp.eye(n)], axis=1), jnp.zeros(n))
    chain, shift = jax.vmap(lambda d, e: jax.lax.scan(link, first, (d, e))[1])(d_end, defect)

    H_local = jnp.einsum("alwqy,blwqy->lwab", local, local)
    g_local = jnp.einsum("alwqy,lwqy->lwa", local, residual)
    upper = jnp.broadcast_to(jnp.eye(k + n)[:k], (L, W, k, k + n))
    C = jnp.concatenate([upper, chain], axis=2)
    c = jnp.concatenate([jnp.zeros((L, W, k)), shift], axis=2)
    H = jnp.einsum("lwai,lwab,lwbj->lij", C, H_local, C, optimize="optimal")
    g = jnp.einsum("lwai,lwa->li", C, g_local + jnp.einsum("lwab,lwb->lwa", H_local, c))
    return Evaluation(residual, local, chain, shift, H, g, defect)


@stored(tuple)
def free_run(structure: Structure, theta: Float[Any, " t"], start: Float[Any, "l n"], batch: Batch):
    """Readings of whole logs from their first state, and the states at the windows' starts."""
    return _side_by_side(lambda run, x0: _whole(structure, theta, run, x0), batch, start)


@stored(lambda found: found[0])
def free_runs(
    structure: Structure, theta: Float[Any, "l t"], start: Float[Any, "l n"], windows: Int[Any, ""], batch: Batch
):
    """Readings `(l, w, q, y)` of the first `windows` of logs from their first state, every log with numbers of its own;
    those of later windows are 0."""
    return [_side_by_side(lambda run, x0, theta: _first(structure, theta, run, x0, windows), batch, start, theta)]


def _one_by_one(plant: AnyPlant, run: Batch):
    """What goes through a window, from its first state and its inputs, to its end; and the inputs of all windows."""
    h, t0 = jnp.asarray(run.h) * plant.pace(), jnp.asarray(run.t0) * plant.pace()
    p = propagator(plant, h)
    steps, at_reading = commands(plant, run)
    W, m = run.slot_step.shape[0], run.step_index.shape[0]

    def window(x, inputs):
        w, u, at_reading, slot_step, slot_part = inputs
        begin = t0 + w * m * h
        states = _window(plant, p, h, begin, x, u)
        y = _readings(plant, h, begin, states, at_reading, slot_step, slot_part)
        return jnp.stack([s[-1] for s in states]), (y, x)

    slots = jnp.asarray(run.slot_step), jnp.asarray(run.slot_part)
    return window, (jnp.arange(W, dtype=float), steps.reshape(W, m, *steps.shape[1:]), at_reading, *slots)


def _late(plant: AnyPlant, run: Batch, x0: Float[Array, " n"]):
    """Readings of one log, each of which may show another window, and the states at its windows' starts."""
    h, t0 = jnp.asarray(run.h) * plant.pace(), jnp.asarray(run.t0) * plant.pace()
    steps, at_reading = commands(plant, run)
    slot_step, slot_part = jnp.asarray(run.slot_step), jnp.asarray(run.slot_part)
    W, m = slot_step.shape[0], run.step_index.shape[0]
    states = _window(plant, propagator(plant, h), h, t0, x0, steps)
    at = (m * jnp.arange(W)[:, None] + slot_step).ravel()
    y = _readings(plant, h, t0, states, at_reading.reshape(at.size, *at_reading.shape[2:]), at, slot_part.ravel())
    return y.reshape(W, -1, y.shape[-1]), jnp.stack([s[: W * m : m] for s in states], axis=-1)


def _whole(structure: Structure, theta: Float[Array, " t"], run: Batch, x0: Float[Array, " n"]):
    """Readings of one log and the states at its windows' starts."""
    plant = _plant_of_run(structure, theta, run)
    if plant.age() is not None:
        return _late(plant, run, x0)
    window, inputs = _one_by_one(plant, run)
    return jax.lax.scan(window, x0, inputs)[1]


def _first(
    structure: Structure, theta: Float[Array, " t"], run: Batch, x0: Float[Array, " n"], windows: Int[Array, ""]
):
    """Readings of one log in its first windows."""
    plant = _plant_of_run(structure, theta, run)
    if plant.age() is not None:
        return _late(plant, run, x0)[0]
    window, inputs = _one_by_one(plant, run)

    def one(w, carry):
        x, y = carry
        x, (seen, _) = window(x, tuple(a[w] for a in inputs))
        return x, y.at[w].set(seen)

    W, q = run.slot_step.shape
    nothing = jnp.zeros((W, q, len(structure.outputs)))
    return jax.lax.fori_loop(0, windows, one, (x0, nothing))[1]
