"""What acts on a plant in time: the logged command after the drive, over every time step and at every reading."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from rwjax.kinds import SERVO
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.plant import Drive, Plant
from rwjax.plant.servo import Tick, goal_delay, outputs_at_once
from rwjax.simulation.batch import Batch
from rwjax.types import Scalar

ON_TIME = 1e-6
"""Part of a period by which a servo's tick may be off a grid point and still counts as on it [1]."""
BEHIND = 0.01
"""Part of a step behind a reading over which it sees a voltage that lags: a lag of far less acts at once [1]."""
BEGUN = 1e-6
"""Part of a step that has passed at least where a lag is asked for its voltage, since over no time it has no mean [1]."""


class Switched(NamedTuple):
    """What acts over steps of time where torque may be off.

    Attributes:
        u: Mean voltage over every step `(s,)` [V], or current [A] or torque [N m].
        powered: Share of every step in which current can flow `(s,)` [1].
    """

    u: Float[Array, " s"]
    powered: Float[Array, " s"]


class Stretch(NamedTuple):
    """A part of a log's time grid, with the readings in it.

    Attributes:
        points: Numbers of its grid points in the log, one after the other, its end included `(s + 1,)`.
        slot_step: Step of the part in which each reading lies `(q,)`.
        slot_part: Part of that step that has passed at the reading `(q,)` [1].
    """

    points: Int[Array, " s1"]
    slot_step: Int[Array, " q"]
    slot_part: Float[Array, " q"]


Acting = Callable[[Stretch], tuple[Any, Float[Array, "q *channels"]]]
"""What acts in a part of a log: over every step arrays with a first axis of steps, and the voltage [V] at every reading."""


def whole_log(run: Batch) -> Stretch:
    """One log from its beginning to the end of its last window's overlap, with all its readings.

    Args:
        run: One log of a batch.

    Returns:
        The part of the grid that is the whole of it; its readings `(w q,)` window after window.
    """
    slot_step = jnp.asarray(run.slot_step)
    W, m = slot_step.shape[0], run.step_index.shape[0]
    step = (m * jnp.arange(W)[:, None] + slot_step).ravel()
    return Stretch(jnp.arange(W * m + len(run.overlap_index) + 1), step, jnp.asarray(run.slot_part).ravel())


def each_window(run: Batch) -> Stretch:
    """The windows of one log, each with its overlap with the next one.

    Args:
        run: One log of a batch.

    Returns:
        Parts of the grid, with a first axis of windows.
    """
    slot_step = jnp.asarray(run.slot_step)
    W, m = slot_step.shape[0], run.step_index.shape[0]
    points = m * jnp.arange(W)[:, None] + jnp.arange(m + len(run.overlap_index) + 1)[None]
    return Stretch(points, slot_step, jnp.asarray(run.slot_part))


def given(plant: Plant, run: Batch) -> Acting:
    """What moves a plant besides its state: the command, or a servo's goal, and whether torque is on.

    It is worked out for the part of the log that is asked for, so that a run of its beginning takes little more than that. A drive that lags
    is an exception: its voltage is filtered over the whole log.

    Args:
        plant: The plant of the log.
        run: One log of a batch.

    Returns:
        What acts in a part of the log: over every step `commands`, `Switched` or `Tick`; and the voltage [V] at every reading, of no
        meaning where a servo gives it.
    """
    if isinstance(plant, OneAxis) and plant.structure.servo is not None:
        ticks = _ticks(plant, run)
        return lambda part: (ticks(part), jnp.zeros(part.slot_step.shape))
    acting = commands(plant, run)
    if not plant.structure.switched:
        return acting
    powered = _powered(run)

    def switched(part: Stretch) -> tuple[Switched, Array]:
        steps, at_reading = acting(part)
        return Switched(steps, powered(part)), at_reading

    return switched


def commands(plant: Plant, run: Batch) -> Acting:
    """Voltage that acts over the steps of one log, and at its readings.

    A delay shifts the command in time, continuously. A reading sees the mean from its own time to the next sample, or over one
    grid step, whichever is shorter. Of a voltage that lags it sees what is there right behind it.

    Args:
        plant: The plant of the log.
        run: One log of a batch.

    Returns:
        What acts in a part of the log: mean voltage over every step `(s,)` or `(s, 2)` [V], and the voltage at every reading `(q,)` or
        `(q, 2)` [V].
    """
    command = jnp.asarray(run.u_command)
    channels = [_of_channel(drive, u, run, plant.pace()) for drive, u in plant.channels(command)]

    def acting(part: Stretch) -> tuple[Array, Array]:
        found = [channel(part) for channel in channels]
        if len(found) == 1:
            return found[0]
        steps, at_reading = (jnp.stack(each, axis=-1) for each in zip(*found, strict=True))
        return steps, at_reading

    return acting


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
    for power in reversed(range(later.bit_length())):
        ahead = jnp.minimum(i + 2**power, len(t) - 1)
        i = jnp.where(t[ahead] <= time, ahead, i)
    return area[i] + u[i] * (time - t[i])  # the first command is taken to have been held before the log


def _held_command(run: Batch, u: Float[Array, " k"]) -> _Held:
    """A command held between the samples of one log."""
    return _Held(run, u, jnp.concatenate([jnp.zeros(1), jnp.cumsum(u * jnp.diff(jnp.asarray(run.t_command)))]))


def _of_channel(drive: Drive, command: Float[Array, " k"], run: Batch, pace: Scalar | float) -> Acting:
    """`commands` of one channel."""
    h = jnp.asarray(run.h)
    width = jnp.minimum(h, jnp.min(jnp.diff(jnp.asarray(run.t_command))))
    held = _held_command(run, jax.vmap(drive.act)(jnp.asarray(command)))
    delay = drive.delay()

    def area(time: Float[Array, " s"], point: Int[Array, " s"], between: bool) -> Float[Array, " s"]:
        """Area of the delayed command."""
        return held.until(time, point, between) if delay is None else held.any_until(time - delay)

    def mean(points: Int[Array, " s1"]) -> Float[Array, " s"]:
        """Mean over the steps between grid points."""
        return jnp.diff(area(h * points.astype(float), points, False)) / h

    def at_once(part: Stretch) -> tuple[Array, Array]:
        point = part.points[0] + part.slot_step
        sample = h * (point.astype(float) + part.slot_part)
        end = jnp.floor((sample + width) / h).astype(int)
        return mean(part.points), (area(sample + width, end, True) - area(sample, point, True)) / width

    if not drive.filters:
        return at_once
    followed = drive.follow(mean(whole_log(run).points), h * pace)

    def lagging(part: Stretch) -> tuple[Array, Array]:
        step, span = part.points[0] + part.slot_step, BEHIND * h
        begin, since = h * step.astype(float), jnp.maximum(part.slot_part, BEGUN) * h
        reading = begin + since
        until = area(reading, step, True)
        before = (until - area(begin, step, False)) / since
        now = (area(reading + span, jnp.floor((reading + span) / h).astype(int), True) - until) / span
        seen = jax.vmap(followed.at, (0, 0, 0, 0, None))(step, before, now, since * pace, span * pace)
        return followed.mean[part.points[:-1]], seen

    return lagging


def _held_at(values: Any, part: Stretch, run: Batch) -> Array:
    """Values of the samples whose command is held when the steps of a part begin."""
    return jnp.asarray(values)[jnp.asarray(run.held)[part.points[:-1] + _early(run)]]


def _powered(run: Batch) -> Callable[[Stretch], Float[Array, " s"]]:
    """Share of every grid step of a part of one log in which current can flow [1]."""
    if not run.enabled.size:
        return lambda part: jnp.ones(len(part.points) - 1)
    h, held = jnp.asarray(run.h), _held_command(run, jnp.asarray(run.enabled))

    def powered(part: Stretch) -> Float[Array, " s"]:
        share = jnp.diff(held.until(h * part.points.astype(float), part.points, False)) / h
        whole = jnp.round(share)
        return jnp.where(jnp.abs(share - whole) < ON_TIME, whole, share)

    return powered


def _ticks(plant: OneAxis, run: Batch) -> Callable[[Stretch], Tick]:
    """What a servo is told in every grid step of a part of one log.

    A goal counts by its mean over the period that begins at the tick, so that a delay of it moves the motion continuously. It is
    exact where samples of the log fall on ticks.
    """
    h, pace, n = jnp.asarray(run.h), plant.pace(), plant.numbers
    T = n[f"{SERVO}.period"] / pace
    since = jnp.asarray(run.clock) - n.get(f"{SERVO}.phase", jnp.zeros(()))
    step = h / T
    delay = plant.delay()
    late = 0.0 if delay is None else delay / pace / T
    outputs = outputs_at_once(plant)
    goal, wait = _held_command(run, jnp.asarray(run.u_command)), goal_delay(plant) / pace
    powered = _powered(run)

    def ticks(part: Stretch) -> Tick:
        q = _snapped((since + h * part.points.astype(float)) / T)  # ticks that a grid point has behind it
        last = jnp.ceil(q) - 1.0
        begin, end, tick = q[:-1], q[1:], last[1:]
        at = tick * T - since
        return Tick(
            ticks=tick > last[:-1],
            part=jnp.clip((tick - begin) / step, 0.0, 1.0),
            goal=(goal.any_until(at + T - wait) - goal.any_until(at - wait)) / T,
            supply=_held_at(run.supply, part, run) if run.supply.size else jnp.ones(begin.shape),
            share=_shares(tick, begin - late, end - late, outputs) / step,
            on=_held_at(run.enabled, part, run) > 0.0 if run.enabled.size else jnp.ones(begin.shape, bool),
            powered=powered(part),
        )

    return ticks


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
