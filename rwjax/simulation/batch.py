"""Logs laid out for simulation: a uniform time grid for each log, cut into windows that run side by side.

A log's samples may be irregular; the grid is not. The command enters every step by its mean over the step, and
readings are taken between grid points, so one path serves regular, jittered and broken sampling. Where the encoder may be
late, windows overlap: a reading belongs to the window in which lies whatever it may show.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.errors import LogError
from rwjax.kinds import is_angle
from rwjax.logs.log import Log, with_earlier
from rwjax.plant.one_axis import Structure

LONGEST_STEP = 5e-3
"""Longest time step [s]; the sampling interval is divided until its parts are no longer than this. Where angles alone
are logged, faster samples share a step."""


EARLIEST = 1.0
"""Time before a log's first sample from which a command may still act [s]."""
MOST_STEPS = 5_000_000  # of one log: three hours at 400 Hz


ALIKE = ("step_index", "late_index", "crowd")
"""Entries of a batch that have no axis of logs."""


class Batch(NamedTuple):
    """Several logs as arrays. Axes: log `l`, window `w`, grid step within a window `m`, reading slot `q`, output `y`.

    `t_command`, `u_command`: the command's samples and, one longer, the times between which each is held; those before
    a cut are below 0.
    `h`, `t0`: grid step and start of each log relative to its run's first sample.
    `slot_step`, `slot_part`: grid step of a reading and the part of the step that has passed.
    `theta_index`, `theta_offset`: a log's numbers are `theta[theta_index] + theta_offset`, in the order of the structure's names `p`.
    `reading`, `weight`: measured outputs and the inverse of their noise (0 where there is none), times the root of `share`.
    """

    t_command: np.ndarray  # l k+1
    u_command: np.ndarray  # l k; of rigs with several commands l k c
    held: np.ndarray  # l g; sample of the command held at every grid point, from `EARLIEST` before the log on
    crowd: np.ndarray  # samples between two grid points at most; only its length matters
    h: np.ndarray  # l
    t0: np.ndarray  # l
    theta_index: np.ndarray  # l p
    theta_offset: np.ndarray  # l p
    slot_step: np.ndarray  # l w q
    slot_part: np.ndarray  # l w q
    slot_sample: np.ndarray  # l w q; -1 where the slot is empty
    reading: np.ndarray  # l w q y
    weight: np.ndarray  # l w q y
    share: np.ndarray  # l w q y; how much of a reading of its own a reading is
    step_index: np.ndarray  # m; only its length matters
    late_index: np.ndarray  # steps by which windows overlap where readings are late; only its length matters

    @property
    def windows(self) -> int:
        """Windows of each log."""
        return self.slot_step.shape[1]

    @property
    def windows_of(self) -> np.ndarray:
        """Windows of each log `(l,)` up to the last one that holds a reading."""
        last = np.max(np.where(self.slot_sample >= 0, np.arange(self.windows)[:, None], 0), axis=(1, 2))
        return last + 1

    @property
    def readings(self) -> float:
        """How many readings the residual holds, those that only repeat a count not counted again."""
        return float(np.sum(self.share[self.weight > 0.0]))

    def inputs_of(self, logs: np.ndarray) -> "Batch":
        """What a free run needs of these logs, as often as they are named; no readings."""
        unused = ("slot_sample", "reading", "weight", "share")
        taken = {name: getattr(self, name)[logs] for name in self._fields if name not in ALIKE + unused}
        return self._replace(**taken, **dict.fromkeys(unused, taken["h"]))

    def of(self, log: int) -> "Batch":
        """One log by itself."""
        return self._replace(**{name: getattr(self, name)[log : log + 1] for name in self._fields if name not in ALIKE})

    def until(self, time: float) -> "Batch":
        """The windows in which the first `time` seconds of every log lie."""
        windows = int(time / (np.min(self.h) * len(self.step_index))) + 1
        axes = ("slot_step", "slot_part", "slot_sample", "reading", "weight", "share")
        cut = {name: getattr(self, name)[:, :windows] for name in axes}
        points = self.held.shape[1] - max(self.windows - windows, 0) * len(self.step_index)
        return self._replace(**cut, held=self.held[:, :points])


def _padded(n: int) -> int:
    """Next of few sizes, so that logs of similar length share one compiled program."""
    size = 16
    while size < n:
        size += max(16, size // 4) // 16 * 16
    return size


LONGEST_RUN = 3
"""Samples in a row at one count that still count as so many readings."""


def share_of_readings(value: np.ndarray, resolution: float) -> np.ndarray:
    """Share `(time,)` by which each reading is a new one.

    The rounding of a count that stays for many samples is one error, not many: at rest it would otherwise outweigh the
    motion. A run of `n` equal counts counts as one reading where `n` exceeds `LONGEST_RUN`; readings in SI count fully.
    """
    if resolution == 0.0:
        return np.ones(len(value))
    change = np.flatnonzero(np.append(True, np.diff(value) != 0.0))
    length = np.diff(np.append(change, len(value)))
    return np.repeat(np.where(length > LONGEST_RUN, 1.0 / length, 1.0), length)


def _grid_of(log: Log, refine: int) -> tuple[float, int]:
    dt = float(np.median(np.diff(log.time)))
    if log.outputs and all(map(is_angle, log.outputs)):
        dt *= max(1, int(LONGEST_STEP / dt + 1e-9))  # an angle, unlike a rate, is smooth between grid points
    h = dt / (refine * int(np.ceil(dt / LONGEST_STEP - 1e-9)))
    span = log.time[-1] - log.time[0]
    steps = max(1, round(span / h))
    if steps > MOST_STEPS:
        widest = int(np.argmax(np.diff(log.time)))
        raise LogError(
            f"{log.name}: {span:.4g} s in steps of {h:.2g} s are too many; the widest gap, {np.diff(log.time)[widest]:.4g} s, "
            f"follows {log.time[widest]:.6g} s: split the log there, or check `time_s`"
        )
    return span / steps, steps  # regular samples fall on grid points to rounding


def _recent(log: Log) -> tuple[np.ndarray, np.ndarray]:
    """Time and command of the last second before a log that was cut out of a run, time from the log's first sample."""
    before, command = log.earlier
    late = before > log.time[0] - EARLIEST
    return before[late] - log.time[0], command[late]


def lay_out(
    structure: Structure,
    logs: Sequence[Log],
    noise: Sequence[dict[str, float]],
    *,
    per_run: Sequence[str] = (),
    refine: int = 1,
) -> Batch:
    """Batch of `logs` with each output divided by its noise (standard deviation, SI).

    Every log has a value of its own of the numbers `per_run`: they follow the shared ones in `theta`, log by log.

    `refine` divides the time step further, to check that a result does not depend on it.
    """
    names = structure.outputs
    grids = [_grid_of(log, refine) for log in logs]
    longest = max(steps for _, steps in grids)
    recent = [_recent(log) for log in logs]
    per_window = 32
    while per_window * 512 < longest * len(logs) and per_window < 1024:
        per_window *= 2
    per_window *= refine
    overlap = int(np.ceil(structure.latest / min(h for h, _ in grids) - 1e-9))
    windows = _padded(-(-longest // per_window))
    samples = _padded(max(len(log.time) + len(before) for log, (before, _) in zip(logs, recent, strict=True)))
    L = len(logs)
    t_command = np.zeros((L, samples + 1))
    u_command = np.zeros((L, samples, *logs[0].command.shape[1:]))
    step = np.zeros((L, samples), int)
    part = np.zeros((L, samples))
    for k, (log, (h, steps)) in enumerate(zip(logs, grids, strict=True)):
        n = len(log.time)
        t = log.time - log.time[0]
        end = t[-1] + h * per_window * windows
        held = np.append(recent[k][0], t)
        t_command[k, : len(held)] = held
        t_command[k, len(held) :] = np.linspace(end, 2.0 * end, samples + 1 - len(held))
        u_command[k] = with_earlier(recent[k][1], log.command)[np.minimum(np.arange(samples), len(held) - 1)]
        position = np.minimum(t / h, steps)
        nearest = np.round(position)
        position = np.where(np.abs(position - nearest) < 1e-6, nearest, position)
        # a sample on a grid point belongs to the step after it, as the held command does
        step[k, :n] = np.minimum(np.floor(position), per_window * windows - 1)
        part[k, :n] = position - step[k, :n]
    window_of = np.maximum(step - overlap, 0) // per_window
    slots = 1 + max(int(np.bincount(window_of[k, : len(log.time)]).max()) for k, log in enumerate(logs))
    slots = -(-slots // 8) * 8
    shape = (L, windows, slots)
    slot_step, slot_part = np.zeros(shape, int), np.zeros(shape)
    slot_sample = np.full(shape, -1)
    reading, weight, share = (np.zeros((*shape, len(names))) for _ in range(3))
    for k, log in enumerate(logs):
        n = len(log.time)
        w = window_of[k, :n]
        first = np.searchsorted(w, w, side="left")
        q = np.arange(n) - first
        slot_step[k, w, q] = step[k, :n] - w * per_window
        slot_part[k, w, q] = part[k, :n]
        slot_sample[k, w, q] = np.arange(n)
        for y, name in enumerate(names):
            if name in log.outputs:
                value = log.outputs[name]
                seen = np.isfinite(value)
                reading[k, w, q, y] = np.where(seen, value, 0.0)
                share[k, w, q, y] = share_of_readings(value, log.resolution.get(name, 0.0))
                weight[k, w, q, y] = np.where(seen, np.sqrt(share[k, w, q, y]) / noise[k][name], 0.0)
    early = round(EARLIEST / min(h for h, _ in grids)) + 1
    points = np.arange(-early, per_window * windows + overlap + 1)
    found = [np.searchsorted(t, h * points, side="right") - 1 for t, (h, _) in zip(t_command, grids, strict=True)]
    held = np.clip(found, 0, samples - 1)
    return Batch(
        t_command=t_command,
        u_command=u_command,
        held=held,
        crowd=np.arange(max(int(np.diff(held, axis=1).max()), 1)),
        h=np.array([h for h, _ in grids]),
        t0=np.array([log.time[0] - log.origin for log in logs]),
        theta_index=_theta_index(structure, L, per_run),
        theta_offset=np.array([structure.vector(log.added) for log in logs]),
        slot_step=slot_step,
        slot_part=slot_part,
        slot_sample=slot_sample,
        reading=reading,
        weight=weight,
        share=share,
        step_index=np.arange(per_window),
        late_index=np.arange(overlap),
    )


def _theta_index(structure: Structure, logs: int, per_run: Sequence[str]) -> np.ndarray:
    index = np.tile(np.arange(len(structure.names)), (logs, 1))
    for k, name in enumerate(per_run):
        index[:, structure.names.index(name)] = len(structure.names) + k + len(per_run) * np.arange(logs)
    return index


def by_sample(batch: Batch, log: int, values: np.ndarray, samples: int) -> np.ndarray:
    """Values per window and slot of one log, in the order of the log's samples."""
    index = batch.slot_sample[log]
    out = np.zeros((samples, *values.shape[2:]))
    used = index >= 0
    out[index[used]] = values[used]
    return out
