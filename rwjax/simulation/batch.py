"""Several logs as arrays on uniform time grids, cut into windows that run side by side: `Batch`."""

from typing import NamedTuple

import numpy as np

WITHOUT_LOG_AXIS = ("step_index", "overlap_index", "sample_index")
"""Entries of a batch that have no axis of logs."""


class Batch(NamedTuple):
    """Several logs as arrays. Axes: log `l`, window `w`, grid step within a window `m`, reading slot `q`, output `y`.

    Attributes:
        t_command: Times between which the samples of the command are held `(l, k+1)` [s]; those before a cut are below 0.
        u_command: Samples of the command `(l, k)`, of rigs with two commands `(l, k, 2)` [V, 1, A, N m or rad].
        enabled: Whether torque is on from a sample of the command on `(l, k)`; `(l, 0)` where it always is.
        supply: Voltage of the supply from a sample of the command on `(l, k)` [V]; `(l, 0)` where a servo needs none.
        clock: Time of each log's first sample on the clock by which a servo ticks `(l,)` [s].
        held: Sample of the command that is held at every grid point, from `EARLIEST` or more before the log on `(l, g)`.
        sample_index: At least as long as the most samples between two grid points, one less than a power of two; only its length matters.
        h: Grid step `(l,)` [s].
        t0: Start of each log after its run's first sample `(l,)` [s].
        theta_index: Entry of `theta` of each of a log's numbers, in the order of the structure's names `(l, p)`.
        theta_offset: What is added to it, in the number's own SI unit `(l, p)`.
        slot_step: Grid step of a reading within its window `(l, w, q)`.
        slot_part: Part of the step that has passed at the reading `(l, w, q)` [1].
        slot_sample: Sample of the log, -1 where the slot is empty `(l, w, q)`.
        reading: Measured outputs `(l, w, q, y)` [rad, rad/s or A].
        weight: Inverse of their noise times the root of `share`, 0 where there is no reading `(l, w, q, y)`.
        share: How far a reading is a new one and not a repeated count `(l, w, q, y)` [1].
        step_index: As long as a window has steps `(m,)`; only its length matters.
        overlap_index: As long as windows overlap in steps where readings are late; only its length matters.
    """

    t_command: np.ndarray
    u_command: np.ndarray
    enabled: np.ndarray
    supply: np.ndarray
    clock: np.ndarray
    held: np.ndarray
    sample_index: np.ndarray
    h: np.ndarray
    t0: np.ndarray
    theta_index: np.ndarray
    theta_offset: np.ndarray
    slot_step: np.ndarray
    slot_part: np.ndarray
    slot_sample: np.ndarray
    reading: np.ndarray
    weight: np.ndarray
    share: np.ndarray
    step_index: np.ndarray
    overlap_index: np.ndarray

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
        """How many readings the residual holds [1]; those that only repeat a count are not counted again."""
        return float(np.sum(self.share, where=self.weight > 0.0))

    def inputs_of(self, logs: np.ndarray) -> "Batch":
        """What a free run needs of some logs, without their readings.

        Args:
            logs: Numbers of the logs `(b,)` [1]; one may stand there several times.

        Returns:
            A batch of these logs.
        """
        unused = ("slot_sample", "reading", "weight", "share")
        taken = {name: getattr(self, name)[logs] for name in self._fields if name not in WITHOUT_LOG_AXIS + unused}
        return self._replace(**taken, **dict.fromkeys(unused, taken["h"]))

    def of(self, log: int) -> "Batch":
        """One log by itself.

        Args:
            log: Number of the log.

        Returns:
            A batch of one log.
        """
        return self._replace(
            **{name: getattr(self, name)[log : log + 1] for name in self._fields if name not in WITHOUT_LOG_AXIS}
        )

    def with_own_numbers(self, count: int) -> "Batch":
        """The same one log, whose numbers are given as its plant has them; of a batch of one log.

        Args:
            count: How many numbers the plant has [1].

        Returns:
            A batch of one log.
        """
        own = np.arange(count)[None]
        return self._replace(theta_index=own, theta_offset=np.zeros(own.shape))

    def until(self, time: float) -> "Batch":
        """The windows in which the beginning of every log lies.

        Args:
            time: Length of the beginning [s].

        Returns:
            A batch of the first windows.
        """
        windows = int(time / (np.min(self.h) * len(self.step_index))) + 1
        axes = ("slot_step", "slot_part", "slot_sample", "reading", "weight", "share")
        cut = {name: getattr(self, name)[:, :windows] for name in axes}
        points = self.held.shape[1] - max(self.windows - windows, 0) * len(self.step_index)
        return self._replace(**cut, held=self.held[:, :points])


def by_sample(batch: Batch, log: int, values: np.ndarray, samples: int) -> np.ndarray:
    """Values per window and slot of one log, in the order of the log's samples.

    Args:
        batch: The logs.
        log: Number of the log.
        values: Any values `(w, q, …)` [any unit].
        samples: How many samples the log has [1].

    Returns:
        The values `(samples, …)` [the same unit], 0 for a sample without a slot.
    """
    index = batch.slot_sample[log].ravel()
    used = np.flatnonzero(index >= 0)
    out = np.zeros((samples, *values.shape[2:]))
    out[index[used]] = values.reshape(len(index), *values.shape[2:])[used]
    return out
