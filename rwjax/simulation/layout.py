"""Logs laid out for simulation: a uniform time grid for each log, cut into windows that run side by side.

A log's samples may be irregular; the grid is not. The command enters every step by its mean over the step, and readings are taken
between grid points. So one path serves regular, jittered and broken sampling. Where the encoder may be late, windows overlap: a
reading belongs to the window that holds the oldest moment which it may show.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import Clock
from rwjax.errors import LogError
from rwjax.kinds import SERVO, is_angle
from rwjax.logs.log import Log, with_earlier
from rwjax.logs.segments import runs_of
from rwjax.plant.structure import Structure
from rwjax.simulation.batch import Batch

OF_JOINT, OF_JOINT_S = 8, 960.0
"""Parts into which a joint's steps are divided at most where its numbers or its motion count, and not the gap alone [1]; and the length
of its logs times these parts [s], so that long logs take less."""
LONG_AGO = 1e4
"""Time on a logger's clock from which on rounding would move a servo's ticks [s]."""
EARLIEST = 1.0
"""Time before a log's first sample from which a command may still act [s]."""
ROOM = 1.1
"""Times that for which arrays have room, up to the next power of two: of usual rates, and of a clock that is a little off, they are as long [1]."""
NEARLY = 0.02
"""Share by which a step may exceed the longest one [1]: by as much a logger's samples may be further apart than it says."""
MOST_STEPS = 5_000_000
"""Most steps of one log: three hours at 400 Hz."""
FEW_WINDOWS = (4, 8)
"""Windows for which arrays have room besides [1]: a segment has few, and empty ones take time."""
LONGEST_RUN = 3
"""Samples in a row at one count that still count as so many readings."""


def _padded(n: int) -> int:
    """Next of few sizes, so that logs of similar length share one compiled program."""
    size = 16
    while size < n:
        size += max(16, size // 4) // 16 * 16
    return size


def share_of_readings(value: np.ndarray, resolution: float) -> np.ndarray:
    """How far each reading is a new one and not a repeated count.

    The rounding of a count that stays for many samples is one error, not many: at rest it would otherwise outweigh the
    motion. A run of `n` equal counts counts as one reading where `n` exceeds `LONGEST_RUN`; readings in SI count fully.

    Args:
        value: Readings `(time,)` [rad, rad/s or A].
        resolution: Their quantisation step, 0 for readings in SI [rad, rad/s or A].

    Returns:
        Shares `(time,)` [1].
    """
    if resolution == 0.0:
        return np.ones(len(value))
    change = np.flatnonzero(np.append(True, np.diff(value) != 0.0))
    length = np.diff(np.append(change, len(value)))
    return np.repeat(np.where(length > LONGEST_RUN, 1.0 / length, 1.0), length)


def _steps_of(structure: Structure, log: Log, refine: int) -> tuple[float, int]:
    """Grid step of one log [s], and how many of them it has. With a servo steps begin at its ticks, and in equal parts between them."""
    dt, longest, servo = float(np.median(np.diff(log.time))), structure.longest_step, structure.servo
    if servo is not None:
        longest = longest if all(map(is_angle, log.outputs)) else min(longest, dt)
        moves = any(issubclass(BY_NAME[name], Clock) for name in structure.effects) or f"{SERVO}.period" in log.added
        off_by = max(servo.period_off_by, 1.0 + moves)  # two ticks would not fit into one step
        parts = refine * int(np.ceil(max(servo.period / longest / (1.0 + NEARLY), off_by) - 1e-9))
        h = servo.period / parts
        return h, _counted(log, h, max(1, int(np.ceil((log.time[-1] - log.time[0]) / h - 1e-6))))
    if log.outputs and all(map(is_angle, log.outputs)):
        dt *= max(1, int((1.0 + NEARLY) * longest / dt))  # an angle, unlike a rate, is smooth between grid points
    h = dt / (refine * int(np.ceil(dt / longest / (1.0 + NEARLY))))
    span = log.time[-1] - log.time[0]
    steps = _counted(log, h, max(1, round(span / h)))
    return span / steps, steps  # regular samples fall on grid points to rounding


def finer(structure: Structure, logs: Sequence[Log]) -> int:
    """Parts into which time steps are divided where a joint is fitted, simulated or predicted.

    Args:
        structure: What the plant is made of.
        logs: The logs.

    Returns:
        The parts [1], 1 for any other kind.
    """
    if structure.kind != "joint":
        return 1
    seconds = max(sum(float(np.ptp(log.time)) for log in logs), 1e-9)
    return int(np.clip(OF_JOINT_S / seconds, 1, OF_JOINT))


def _counted(log: Log, h: float, steps: int) -> int:
    """A number of steps of a length [s] that a log may have."""
    if steps > MOST_STEPS:
        span, widest = log.time[-1] - log.time[0], int(np.argmax(np.diff(log.time)))
        raise LogError(
            f"{log.name}: {span:.4g} s in steps of {h:.2g} s are too many; the widest gap, {np.diff(log.time)[widest]:.4g} s, "
            f"follows {log.time[widest]:.6g} s: split the log there, or check `time_s`"
        )
    return steps


def _recent(log: Log) -> tuple[np.ndarray, np.ndarray]:
    """Time and command of the last second before a log that was cut out of a run, time from the log's first sample."""
    before, command = log.earlier
    late = before > log.time[0] - EARLIEST
    return before[late] - log.time[0], command[late]


class _Grid(NamedTuple):
    """The time grids of several logs: step `h` [s] and number of `steps` of each, and windows of equal size.

    `per_window`: steps of a window; `windows`: of each log; `overlap`: steps by which windows overlap.
    """

    h: list[float]
    steps: list[int]
    per_window: int
    windows: int
    overlap: int


def _grid_of(structure: Structure, logs: Sequence[Log], refine: int) -> _Grid:
    """Time grids of several logs, with few sizes of windows."""
    grids = [_steps_of(structure, log, refine) for log in logs]
    longest = max(steps for _, steps in grids)
    per_window = 32
    while per_window * 512 < longest * len(logs) and per_window < 1024:
        per_window *= 2
    per_window *= refine
    overlap = int(np.ceil(structure.longest_encoder_delay / min(h for h, _ in grids) - 1e-9))
    needed = -(-longest // per_window)
    windows = next((few for few in FEW_WINDOWS if few >= needed), _padded(needed))
    return _Grid([h for h, _ in grids], [n for _, n in grids], per_window, windows, overlap)


def _commands(logs: Sequence[Log], grid: _Grid) -> tuple[np.ndarray, np.ndarray]:
    """`t_command` and `u_command` of a batch: after its last sample a log's last command is held."""
    recent = [_recent(log) for log in logs]
    samples = _padded(max(len(log.time) + len(before) for log, (before, _) in zip(logs, recent, strict=True)))
    t_command = np.zeros((len(logs), samples + 1))
    u_command = np.zeros((len(logs), samples, *logs[0].command.shape[1:]))
    for k, (log, (before, earlier)) in enumerate(zip(logs, recent, strict=True)):
        t = log.time - log.time[0]
        end = t[-1] + grid.h[k] * grid.per_window * grid.windows
        held = np.append(before, t)
        t_command[k, : len(held)] = held
        t_command[k, len(held) :] = np.linspace(end, 2.0 * end, samples + 1 - len(held))
        u_command[k] = with_earlier(earlier, log.command)[np.minimum(np.arange(samples), len(held) - 1)]
    return t_command, u_command


def _sampled(structure: Structure, logs: Sequence[Log], u_command: np.ndarray) -> dict[str, np.ndarray]:
    """The entries of a batch that change with the samples of the command beside it; those before a cut are not known."""

    def by_sample(values: list[np.ndarray | None]) -> np.ndarray:
        found = np.zeros((len(logs), u_command.shape[1]))
        for k, (log, value) in enumerate(zip(logs, values, strict=True)):
            value = np.ones(len(log.time)) if value is None else value
            first = len(_recent(log)[0])
            found[k] = value[np.clip(np.arange(found.shape[1]) - first, 0, len(value) - 1)]
        return found

    duty = structure.servo is not None and structure.command == "duty" and "drive.supply" not in structure.names
    return {
        "enabled": by_sample([log.enabled for log in logs])[:, : None if structure.switched else 0],
        "supply": by_sample([log.supply for log in logs])[:, : None if duty else 0],
        "clock": np.array([_clock(structure, log) for log in logs]),
    }


def _clock(structure: Structure, log: Log) -> float:
    """`clock` of one log of a batch: of one that counts from long ago, less whole periods."""
    start = log.time[0] - log.origin
    if structure.servo is None:
        return start
    return start + (log.origin if abs(log.origin) < LONG_AGO else log.origin % structure.servo.period)


def _held(t_command: np.ndarray, grid: _Grid) -> np.ndarray:
    """`held` of a batch."""
    early = 1 << int(ROOM * EARLIEST / min(grid.h)).bit_length()
    points = np.arange(-early, grid.per_window * grid.windows + grid.overlap + 1)
    found = [np.searchsorted(t, h * points, side="right") - 1 for t, h in zip(t_command, grid.h, strict=True)]
    return np.clip(found, 0, t_command.shape[1] - 2)


class _Placed(NamedTuple):
    """Where the samples of one log lie: grid step within the window and its part, window and slot `(n,)`."""

    step: np.ndarray
    part: np.ndarray
    window: np.ndarray
    slot: np.ndarray


def _placed(log: Log, grid: _Grid, k: int) -> _Placed:
    """Windows and slots of the samples of the log numbered `k`."""
    position = np.minimum((log.time - log.time[0]) / grid.h[k], grid.steps[k])
    nearest = np.round(position)
    position = np.where(np.abs(position - nearest) < 1e-6, nearest, position)
    # a sample on a grid point belongs to the step after it, as the held command does
    step = np.minimum(np.floor(position), grid.per_window * grid.windows - 1).astype(int)
    window = np.maximum(step - grid.overlap, 0) // grid.per_window
    slot = np.arange(len(step)) - np.searchsorted(window, window, side="left")
    return _Placed(step - window * grid.per_window, position - step, window, slot)


def _readings(
    structure: Structure, logs: Sequence[Log], noise: Sequence[dict[str, float]], grid: _Grid
) -> dict[str, np.ndarray]:
    """The entries of a batch that belong to reading slots."""
    placed = [_placed(log, grid, k) for k, log in enumerate(logs)]
    slots = -(-max(int(np.bincount(at.window).max()) for at in placed) // 8) * 8
    shape = (len(logs), grid.windows, slots)
    slot_step, slot_part = np.zeros(shape, int), np.zeros(shape)
    slot_sample = np.full(shape, -1)
    reading, weight, share = (np.zeros((*shape, len(structure.outputs))) for _ in range(3))
    for k, (log, at) in enumerate(zip(logs, placed, strict=True)):
        w, q = at.window, at.slot
        slot_step[k, w, q] = at.step
        slot_part[k, w, q] = at.part
        slot_sample[k, w, q] = np.arange(len(w))
        for y, name in enumerate(structure.outputs):
            if name in log.outputs:
                value = log.outputs[name]
                seen = np.isfinite(value)
                reading[k, w, q, y] = np.where(seen, value, 0.0)
                share[k, w, q, y] = share_of_readings(value, log.resolution.get(name, 0.0))
                weight[k, w, q, y] = np.where(seen, np.sqrt(share[k, w, q, y]) / noise[k][name], 0.0)
    return dict(
        slot_step=slot_step, slot_part=slot_part, slot_sample=slot_sample, reading=reading, weight=weight, share=share
    )


def lay_out(
    structure: Structure,
    logs: Sequence[Log],
    noise: Sequence[dict[str, float]],
    *,
    per_run: Sequence[str] = (),
    refine: int = 1,
) -> Batch:
    """Logs laid out for simulation.

    Args:
        structure: What the plant is made of.
        logs: The logs.
        noise: For each log the standard deviation of each logged output [rad, rad/s or A], by which its readings are divided.
        per_run: Numbers of which every run has a value of its own; they follow the shared ones in `theta`, run by run.
        refine: Divides the time step further [1], to check that a result does not depend on it.

    Returns:
        The batch.

    Raises:
        LogError: A log has too many time steps.
    """
    grid = _grid_of(structure, logs, refine)
    t_command, u_command = _commands(logs, grid)
    held = _held(t_command, grid)
    return Batch(
        t_command=t_command,
        u_command=u_command,
        **_sampled(structure, logs, u_command),
        held=held,
        sample_index=np.arange(max(2 ** int(np.diff(held, axis=1).max()).bit_length() - 1, 1)),
        h=np.array(grid.h),
        t0=np.array([log.time[0] - log.origin for log in logs]),
        theta_index=_theta_index(structure, runs_of(logs), per_run),
        theta_offset=np.array([structure.vector(log.added) for log in logs]),
        step_index=np.arange(grid.per_window),
        overlap_index=np.arange(grid.overlap),
        **_readings(structure, logs, noise, grid),
    )


def _theta_index(structure: Structure, runs: np.ndarray, per_run: Sequence[str]) -> np.ndarray:
    """`theta_index` of a batch, whose logs belong to these runs."""
    index = np.tile(np.arange(len(structure.names)), (len(runs), 1))
    for k, name in enumerate(per_run):
        index[:, structure.names.index(name)] = len(structure.names) + k + len(per_run) * runs
    return index
