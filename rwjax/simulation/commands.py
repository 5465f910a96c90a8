"""What acts on a plant in time: the logged command after the drive, over every time step and at every reading."""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from rwjax.kinds import SERVO
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.plant import Drive, Plant
from rwjax.plant.servo import Tick, goal_delay, outputs_at_once
from rwjax.simulation.batch import Batch
from rwjax.types import Scalar

ON_TIME = 1e-6
"""Part of a period by which a servo's tick may be off a grid point and still counts as on it [1]."""


class Switched(NamedTuple):
    """What acts over steps of time where torque may be off.

    Attributes:
        u: Mean voltage over every step `(s,)` [V], or current [A] or torque [N m].
        powered: Share of every step in which current can flow `(s,)` [1].
    """

    u: Float[Array, " s"]
    powered: Float[Array, " s"]


def given(plant: Plant, run: Batch) -> tuple[Any, Float[Array, "w q *channels"]]:
    """What moves a plant besides its state: the command, or a servo's goal, and whether torque is on.

    Args:
        plant: The plant of the log.
        run: One log of a batch.

    Returns:
        Over every grid step of the log and of its last window's overlap, arrays with a first axis of steps: `commands`, `Switched`
        or `Tick`; and the voltage [V] at every reading, of no meaning where a servo gives it.
    """
    if isinstance(plant, OneAxis) and plant.structure.servo is not None:
        return _ticks(plant, run), jnp.zeros(run.slot_step.shape)
    steps, at_reading = commands(plant, run)
    return (Switched(steps, _powered(run)), at_reading) if plant.structure.switched else (steps, at_reading)


def commands(plant: Plant, run: Batch) -> tuple[Float[Array, "s *channels"], Float[Array, "w q *channels"]]:
    """Voltage that acts over the steps of one log, and at its readings.

    A delay shifts the command in time, continuously. A reading sees the mean from its own time to the next sample, or over one
    grid step, whichever is shorter.

    Args:
        plant: The plant of the log.
        run: One log of a batch.

    Returns:
        Mean voltage over every grid step of the log and of its last window's overlap `(s,)` or `(s, 2)` [V], and the voltage at
        every reading `(w, q)` or `(w, q, 2)` [V].
    """
    return plant.by_channel(
        lambda drive, command: _of_channel(drive, command, run, plant.pace()),
        jnp.asarray(run.u_command),
    )


def _grid(run: Batch) -> Int[Array, " s"]:
    """Numbers of the grid points of one log, those of its last window's overlap and the end included."""
    return jnp.arange(run.slot_step.shape[0] * run.step_index.shape[0] + len(run.overlap_index) + 1)


def _early(run: Batch) -> int:
    """Grid points before the first one at which a command is known to be held."""
    return run.held.shape[0] - (run.slot_step.shape[0] * run.step_index.shape[0] + len(run.overlap_index) + 1)


class _Held(NamedTuple):
    """The command of a log as an area: its integral over time up to samples, and to any time."""

    run: Batch
    u: Float[Array, " k"]
    area: Float[Array, " k1"]

    def until(self, time: Float[Array, " s"], point: Int[Array, " s"], between: bool) -> Float[Array, " s"]:
        """Area of the command up to some times, given the grid points before them."""
        held, t = jnp.asarray(self.run.held), jnp.asarray(self.run.t_command)
        later = len(self.run.sample_index) if between else 0
        return _area_until(held, t, self.u, self.area, time, point + _early(self.run), later)

    def any_until(self, time: Float[Array, " s"]) -> Float[Array, " s"]:
        """`until` any time."""
        first, last = -_early(self.run), self.run.held.shape[0] - _early(self.run) - 1
        point = jnp.clip(jnp.floor(time / jnp.asarray(self.run.h)).astype(int), first, last)
        return self.until(time, point, True)


@partial(jax.jit, static_argnames="later")  # traced once for all plants
def _area_until(
    held: Int[Array, " g"],
    t: Float[Array, " k1"],
    u: Float[Array, " k"],
    area: Float[Array, " k1"],
    time: Float[Array, " s"],
    point: Int[Array, " s"],
    later: int,
) -> Float[Array, " s"]:
    """Area of a command up to some times; `later`: how many samples the held one may be behind."""
    i = held[point]
    for _ in range(later):
        i = jnp.where(t[i + 1] <= time, i + 1, i)
    return area[i] + u[i] * (time - t[i])  # the first command is taken to have been held before the log


def _held_command(run: Batch, u: Float[Array, " k"]) -> _Held:
    """A command held between the samples of one log."""
    return _Held(run, u, jnp.concatenate([jnp.zeros(1), jnp.cumsum(u * jnp.diff(jnp.asarray(run.t_command)))]))


def _of_channel(
    drive: Drive, command: Float[Array, " k"], run: Batch, pace: Scalar | float
) -> tuple[Float[Array, " s"], Float[Array, "w q"]]:
    """`commands` of one channel."""
    t, h, slot_step = jnp.asarray(run.t_command), jnp.asarray(run.h), jnp.asarray(run.slot_step)
    W, m = slot_step.shape[0], run.step_index.shape[0]
    held = _held_command(run, jax.vmap(drive.act)(jnp.asarray(command)))
    delay = drive.delay()

    def acting(time: Float[Array, " s"], point: Int[Array, " s"], between: bool) -> Float[Array, " s"]:
        """Area of the delayed command."""
        return held.until(time, point, between) if delay is None else held.any_until(time - delay)

    grid = _grid(run)
    steps = drive.follow(jnp.diff(acting(h * grid.astype(float), grid, False)) / h, h * pace)
    point = (m * jnp.arange(W)[:, None] + slot_step).ravel()
    sample = h * (point.astype(float) + jnp.asarray(run.slot_part).ravel())
    width = jnp.minimum(h, jnp.min(jnp.diff(t)))
    end = jnp.floor((sample + width) / h).astype(int)
    readings = (acting(sample + width, end, True) - acting(sample, point, True)) / width
    if drive.filters:  # a voltage that lags does not jump between steps
        readings = steps[point]
    return steps, readings.reshape(W, -1)


def _on(run: Batch) -> Bool[Array, " s"]:
    """Whether torque is on when a grid step of one log begins."""
    held = jnp.asarray(run.held)[_early(run) : -1]
    return jnp.asarray(run.enabled)[held] > 0.0 if run.enabled.size else jnp.ones(held.shape, bool)


def _powered(run: Batch) -> Float[Array, " s"]:
    """Share of every grid step of one log in which current can flow [1]."""
    h, grid = jnp.asarray(run.h), _grid(run)
    if not run.enabled.size:
        return jnp.ones(len(grid) - 1)
    held = _held_command(run, jnp.asarray(run.enabled))
    share = jnp.diff(held.until(h * grid.astype(float), grid, False)) / h
    whole = jnp.round(share)
    return jnp.where(jnp.abs(share - whole) < ON_TIME, whole, share)


def _ticks(plant: OneAxis, run: Batch) -> Tick:
    """What a servo is told in every grid step of one log.

    A goal counts by its mean over the period that begins at the tick, so that a delay of it moves the motion continuously. It is
    exact where samples of the log fall on ticks.
    """
    h, pace, n = jnp.asarray(run.h), plant.pace(), plant.numbers
    T = n[f"{SERVO}.period"] / pace
    since = jnp.asarray(run.clock) - n.get(f"{SERVO}.phase", jnp.zeros(()))
    q = _snapped((since + h * _grid(run).astype(float)) / T)  # ticks that a grid point has behind it
    last = jnp.ceil(q) - 1.0
    begin, end, tick = q[:-1], q[1:], last[1:]
    step = h / T
    delay = plant.delay()
    late = 0.0 if delay is None else delay / pace / T
    outputs = outputs_at_once(plant)
    goal, at = _held_command(run, jnp.asarray(run.u_command)), tick * T - since
    wait = goal_delay(plant) / pace
    held = jnp.asarray(run.held)[_early(run) : -1]
    return Tick(
        ticks=tick > last[:-1],
        part=jnp.clip((tick - begin) / step, 0.0, 1.0),
        goal=(goal.any_until(at + T - wait) - goal.any_until(at - wait)) / T,
        supply=jnp.asarray(run.supply)[held] if run.supply.size else jnp.ones(held.shape),
        share=_shares(tick, begin - late, end - late, outputs) / step,
        on=_on(run),
        powered=_powered(run),
    )


def _shares(
    tick: Float[Array, " s"], begin: Float[Array, " s"], end: Float[Array, " s"], outputs: int
) -> Float[Array, "s outputs"]:
    """How many ticks long each of the newest outputs acts between two times in ticks, the last one for all that came before it."""

    def one(k: int) -> Float[Array, " s"]:
        lower = -jnp.inf if k == outputs - 1 else tick - k
        upper = jnp.inf if k == 0 else tick - k + 1.0
        return jnp.maximum(jnp.minimum(end, upper) - jnp.maximum(begin, lower), 0.0)

    return jnp.stack([one(k) for k in range(outputs)], axis=1)


def _snapped(q: Float[Array, " s"]) -> Float[Array, " s"]:
    """Times in ticks, those that rounding alone keeps off a tick put onto it; derivatives are those of the times."""
    whole = jnp.round(q)
    return q + jax.lax.stop_gradient(jnp.where(jnp.abs(q - whole) < ON_TIME, whole - q, 0.0))
