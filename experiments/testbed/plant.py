"""The testbed's motor, wheel and axis for the firmware in simavr: the separate simulator, moved a millisecond at a time.

It shares no code with the library: exact stick and slip in steps of 0.1 ms (`experiments/blind`). The ESC is its drive:
pulse width to volts, and whatever dead zone, lag, supply sag … the truth holds.
"""

import numpy as np
from numba import njit

from experiments.blind.axis import push, warmth
from experiments.blind.drive import follow, shape
from experiments.blind.sensors import encoder
from experiments.blind.simulator import STEP, Truth, advance
from experiments.blind.truth import LOST, OMEGA, PSI, STATES, THETA, W
from firmware.simavr.avr import F_CPU

LINES = 1024  # of both encoders
NEUTRAL_US, VOLTS_PER_US = 1500.0, 0.02
ESC_CLOCK_US = 0.5
"""To which the ESC measures a pulse."""
PER_RAD = 4 * LINES / (2 * np.pi)  # states of an encoder
SEEN = np.array([PSI, W, LOST, THETA, OMEGA])


@njit(cache=True)
def _move(x, u, t, length, p):
    """Moves `x` by `length`; rows of SEEN states, the first of them at the start."""
    n = max(int(np.ceil(length / STEP - 1e-9)), 1)
    h = length / n
    out = np.empty((n + 1, 5))
    slope, half = np.zeros(STATES), np.zeros(STATES)
    v = shape(u, p)
    for j in range(n + 1):
        out[j, 0], out[j, 1], out[j, 2], out[j, 3], out[j, 4] = x[PSI], x[W], x[LOST], x[THETA], x[OMEGA]
        if j == n:
            break
        middle = t + (j + 0.5) * h
        volts = follow(x, v, middle, h, p)
        warm = warmth(middle, p) if p.drift != 0.0 or p.drift_viscous != 0.0 else 0.0
        advance(x, volts, push(middle, p), warm, h, p, slope, half)
    return out


class Testbed:
    """One axis with a reaction wheel on output 1; encoder 1 on the axis, encoder 2 on the wheel."""

    __test__ = False  # no test, whatever pytest makes of the name

    def __init__(self, truth: Truth) -> None:
        self.truth, self.p = truth, truth.array()
        self.late = truth.delay
        self.x = np.zeros(STATES)
        self.pace = float(np.exp(-truth.clock))  # seconds in one second of the board's clock
        self._past = np.zeros((0, 2))  # time and angle of the axis encoder, for a late one

    def advance(self, start: int, end: int, width_us: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """See `firmware.simavr.bench.Plant`."""
        width = ESC_CLOCK_US * round(width_us[0] / ESC_CLOCK_US)
        u = VOLTS_PER_US * (width - NEUTRAL_US) if width else 0.0
        t, length = start / F_CPU * self.pace, (end - start) / F_CPU * self.pace
        rows = _move(self.x, u, t, length, self.p)
        axis = encoder(self.truth, rows[:, 0], rows[:, 1], rows[:, 2], self.p)[0]
        times = t + length * np.linspace(0.0, 1.0, len(rows))
        if self.truth.sensor_delay > 0.0:
            self._past = np.concatenate([self._past[self._past[:, 0] > t - 1.0], np.column_stack([times, axis])])
            axis = np.interp(times - self.truth.sensor_delay, self._past[:, 0], self._past[:, 1])
        cycles = np.linspace(start, end, len(rows))
        return cycles, PER_RAD * np.column_stack([axis, rows[:, 3]])
