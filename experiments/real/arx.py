"""A plain baseline: a linear difference equation from command to reading (ARX), by least squares, judged by its free run.

y[k] = a1 y[k-1] + … + an y[k-n] + b1 u[k-1] + … + bn u[k-n] + c

Order and step are those of the least free-run error on the logs that are fitted. It knows no physics. Torque that is off counts as a
command of 0.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter, lfiltic

from rwjax.logs.log import Log

ORDERS = (1, 2, 3, 4)
STEPS = (1, 2, 5, 10, 20)
"""Steps of the equation, in samples of the logs."""


class Grid(NamedTuple):
    """A log on even steps: time [s], command and reading [SI]."""

    time: np.ndarray
    u: np.ndarray
    y: np.ndarray


class Equation(NamedTuple):
    """A fitted equation: its step [s], and its coefficients in the order above."""

    step: float
    order: int
    numbers: np.ndarray

    def run(self, grid: Grid) -> np.ndarray:
        """Free run from the first readings, as many as its order [SI]."""
        n, a, b = self.order, self.numbers[: self.order], self.numbers[self.order : 2 * self.order]
        given = lfilter(np.append(0.0, b), [1.0], grid.u)[n:] + self.numbers[-1]
        denominator = np.append(1.0, -a)
        start = lfiltic([1.0], denominator, grid.y[:n][::-1])
        with np.errstate(all="ignore"):
            return np.append(grid.y[:n], lfilter([1.0], denominator, given, zi=start)[0])


def on_grid(log: Log, signal: str, step: float) -> Grid:
    """A log on even steps, its command held."""
    y = log.outputs[signal]
    seen = np.isfinite(y)
    time = np.arange(log.time[0], log.time[-1], step)
    held = np.searchsorted(log.time, time + 1e-9, side="right") - 1
    command = log.command if log.enabled is None else log.command * log.enabled
    return Grid(time, command[held], np.interp(time, log.time[seen], y[seen]))


def equation(grids: Sequence[Grid], step: float, order: int) -> Equation:
    """The equation of an order by least squares."""
    rows, aims = [], []
    for grid in grids:
        past = [x[order - k : len(x) - k] for x in (grid.y, grid.u) for k in range(1, order + 1)]
        rows.append(np.stack([*past, np.ones(max(len(grid.y) - order, 0))], axis=1))
        aims.append(grid.y[order:])
    numbers = np.linalg.lstsq(np.concatenate(rows), np.concatenate(aims), rcond=None)[0]
    return Equation(step, order, numbers)


def square_errors(found: Equation, log: Log, signal: str) -> np.ndarray:
    """Squared error of a free run at the log's readings; infinite where the run goes beyond all bounds."""
    grid = on_grid(log, signal, found.step)
    if len(grid.time) <= found.order:
        return np.full(len(log.time), np.nan)
    run = found.run(grid)
    if not np.all(np.abs(run) < 1e9):
        return np.full(len(log.time), np.inf)
    return np.square(np.interp(log.time, grid.time, run) - log.outputs[signal])


def rms(found: Equation, logs: Sequence[Log], signal: str) -> float:
    """Free-run RMS error of all logs together [SI]."""
    return float(np.sqrt(np.nanmean(np.concatenate([square_errors(found, log, signal) for log in logs]))))


def best(logs: Sequence[Log], signal: str) -> Equation:
    """The equation with the least free-run error on the logs themselves."""
    sample = float(np.median(np.diff(logs[0].time)))
    tried = []
    for factor in STEPS:
        grids = [on_grid(log, signal, factor * sample) for log in logs]
        grids = [grid for grid in grids if len(grid.time) > 2 * max(ORDERS)]
        tried += [equation(grids, factor * sample, order) for order in ORDERS if grids]
    return min(tried, key=lambda one: rms(one, logs, signal))
