"""BAM's way: friction models of rising size fitted by simulation and a global search, the one with the least error on other data kept.

The last third of the training log chooses. The simulation is scipy's in numba, the search is scipy's differential evolution.
"""

import numpy as np
from numba import njit
from scipy.optimize import differential_evolution

from experiments.peers.problems import Log, Problem

STRIBECK = ((0.0, 4.0), (0.05, 10.0))  # excess in sizes of the dry friction, velocity in tens of the smoothing width
MODELS = {"viscous": (0, 1, 3), "Coulomb": (0, 1, 2, 3), "Stribeck": (0, 1, 2, 3, 4, 5)}
chosen: list[str] = []


@njit(cache=True)
def _run(z, h, u, x, v, reads, gain, kp, load, width):  # reason: numba's types
    found = np.empty(len(u))
    for k in range(len(u)):
        found[k] = v if reads == 1 else x
        effort = u[k, 0] if kp == 0.0 else u[k, 1] * min(max(kp * (u[k, 0] - x), -1.0), 1.0)
        force = (gain * effort - z[3] if gain != 0.0 else z[3] * effort) - load * np.sin(x)
        dry = z[2] * (1.0 + z[4] * np.exp(-((v / (10.0 * width * z[5])) ** 2)))
        free = v + h * (force - z[1] * v) / z[0]
        v = np.sign(free) * max(abs(free) - h * dry / z[0], 0.0)
        x += h * v
    return found


def run(p: Problem, z: np.ndarray, log: Log) -> np.ndarray:
    """A free run."""
    own = np.concatenate([z[:4] * np.array(p.scale), z[4:]])
    return _run(own, log.t[1] - log.t[0], log.u, *p.start(log), p.reads, p.gain or 0.0, p.kp or 0.0, p.load, p.width)


def fit(p: Problem) -> np.ndarray:
    """The friction model that follows the last third of the log best."""
    log, at = p.train, 2 * len(p.train.t) // 3
    bounds, best = (*p.bounds, *STRIBECK), (np.inf, np.zeros(6))
    for name, free in MODELS.items():

        def of(z: np.ndarray, free: tuple[int, ...] = free) -> np.ndarray:
            whole = np.array([1.0, 0.0, 0.0, 0.0 if p.gain else 1.0, 0.0, 1.0])
            whole[list(free)] = z
            return whole

        def error(z: np.ndarray, part: slice) -> float:
            return float(np.mean((run(p, of(z), log) - log.y)[part] ** 2))

        found = differential_evolution(
            error, [bounds[k] for k in free], args=(slice(0, at),), maxiter=60, seed=1, tol=1e-6
        ).x
        if (left := error(found, slice(at, None))) < best[0]:
            best = left, of(found)
            chosen[:] = [name]
    return best[1]


def says() -> str:
    """What it names."""
    return f"{chosen[0]} friction, of {len(MODELS)} models"
