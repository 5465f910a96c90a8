"""The two logs of EMPS, and the same in coarser steps."""

import numpy as np

from experiments.realdata import need

Log = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Time [s], voltage [V] and position [m]."""


def log(name: str) -> Log:
    """One of the two logs, `DATA_EMPS` or `DATA_EMPS_PULSES`."""
    t, u, x = np.genfromtxt(need() / "emps" / f"{name}.csv", delimiter=",", skip_header=1, usecols=(0, 1, 2)).T
    return t, u, x


def coarser(every: int, t: np.ndarray, u: np.ndarray, x: np.ndarray) -> Log:
    """A log in steps of several samples, each with the mean command of its samples."""
    count = len(t) // every
    return t[::every][:count], u[: every * count].reshape(count, every).mean(axis=1), x[::every][:count]
