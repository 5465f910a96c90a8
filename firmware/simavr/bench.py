"""A board on the bench, in lock-step with what hangs on it: pulses go to the plant, the edges of its encoders come back.

Simulated time only: the same bytes at the same cycles in every run.
"""

from collections import deque
from typing import Protocol

import numpy as np
from numba import njit

from firmware.simavr.avr import F_CPU, PIN_A, Avr

STEP = F_CPU // 1000  # cycles between two exchanges; an edge is placed at its own cycle
ESC_CYCLES = 3 * F_CPU // 1000
"""An ESC acts on a pulse 3 ms after its start: the longest one lasts 2 ms, its own loop another. A `STEP` must not be longer
than the difference, or a pulse would be seen too late."""
LEVEL_A, LEVEL_B = np.array([0, 1, 1, 0], np.uint8), np.array([0, 0, 1, 1], np.uint8)


class Plant(Protocol):
    """What hangs on the board. `late` is how long after the ESC the command acts [s]."""

    late: float

    def advance(self, start: int, end: int, width_us: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """Moves from cycle `start` to `end` under these pulses.

        Returns increasing cycles `(n,)` from `start` to `end`, and there both encoders' angles `(n, 2)` in states (four
        of them a line).
        """
        ...


@njit(cache=True)
def _crossings(cycles, angles):
    """Every change of state of two encoders: cycle, encoder, state after it; in the order found."""
    found = []
    for j in range(2):
        for k in range(len(cycles) - 1):
            a, b = angles[k, j], angles[k + 1, j]
            old, new = np.floor(a), np.floor(b)
            while old != new:
                up = new > old
                wall = old + 1.0 if up else old
                old += 1.0 if up else -1.0
                share = (wall - a) / (b - a)
                found.append((cycles[k] + share * (cycles[k + 1] - cycles[k]), j, old))
    out = np.empty((len(found), 3))
    for n in range(len(found)):
        out[n, 0], out[n, 1], out[n, 2] = found[n]
    return out


def edges(cycles: np.ndarray, angles: np.ndarray, pin_a: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Levels of the encoders' pins for `Avr.edges`."""
    found = _crossings(np.asarray(cycles, float), angles)
    found = found[np.argsort(found[:, 0], kind="stable")]
    state, a = found[:, 2].astype(np.int64) % 4, np.array(pin_a)[found[:, 1].astype(int)]
    cycle = np.repeat(found[:, 0].astype(np.uint64), 2)  # the level that has not changed is handed in as well: no edge
    return cycle, np.column_stack([a, a + 2]).ravel(), np.column_stack([LEVEL_A[state], LEVEL_B[state]]).ravel()


class Bench:
    """A board and its plant. `run` is the only thing that moves time."""

    def __init__(self, avr: Avr, plant: Plant) -> None:
        self.avr, self.plant = avr, plant
        self.widths = (0.0, 0.0)  # us, that the ESCs act on; 0: none yet
        self.angles = np.zeros(2)  # of the encoders, states
        self._moved = avr.cycle  # up to which the plant has been moved: the board stops a few cycles later
        self._coming: deque[tuple[int, int, float]] = deque()  # cycle, output, width

    def run(self, until: int) -> None:
        """Moves board and plant to a cycle."""
        while (start := self._moved) < until:
            end = min(until, start + STEP)
            if self._coming:
                end = min(end, max(self._coming[0][0], start + 1))
            cycles, angles = self.plant.advance(start, end, self.widths)
            self.angles = angles[-1]
            self.avr.edges(*edges(cycles, angles, PIN_A[self.avr.mcu]))
            self.avr.run(end)
            self._moved = end
            late = ESC_CYCLES + round(self.plant.late * F_CPU)
            self._coming.extend((p.rise + late, p.output, p.width_us) for p in self.avr.pulses())
            while self._coming and self._coming[0][0] <= end:
                _, output, width = self._coming.popleft()
                self.widths = (width, self.widths[1]) if output == 0 else (self.widths[0], width)


def counts(states: np.ndarray) -> np.ndarray:
    """What a decoder of both edges of A reads at these angles, after a start at 0."""
    return (np.floor(states).astype(np.int64) + 1) // 2
