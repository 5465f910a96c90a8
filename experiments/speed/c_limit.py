"""The limit: the same plant and step in C, windows in SIMD lanes, built with gcc into build/."""

import ctypes
import shutil
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from experiments.speed.problem import TRUTH, Arrays, first_states

SOURCE = Path(__file__).with_name("c_limit.c")
BUILD = Path(__file__).parents[2] / "build"
LANES = 8
SAMPLES = 40  # of a window
TOLERANCE = 1e-9
ROWS = np.ctypeslib.ndpointer(np.float64, flags="C")


@dataclass(frozen=True)
class Found:
    """Optimum: numbers (inertia, viscous, coulomb), initial state, half sum of squares, evaluations."""

    numbers: np.ndarray
    first: np.ndarray
    cost: float
    evaluations: int


def available() -> bool:
    """Whether there is a compiler."""
    return shutil.which("gcc") is not None


@cache
def library() -> ctypes.CDLL:
    """The compiled program."""
    BUILD.mkdir(exist_ok=True)
    target = BUILD / "c_limit.so"
    if not target.exists() or target.stat().st_mtime < SOURCE.stat().st_mtime:
        wide = ["-O3", "-march=native", "-mprefer-vector-width=512", "-Wno-psabi"]
        subprocess.run(["gcc", *wide, "-shared", "-fPIC", "-o", target, SOURCE, "-lm"], check=True)
    c = ctypes.CDLL(str(target))
    i, f = ctypes.c_int, ctypes.c_double
    c.simulate.argtypes = [i, i, f, f, ROWS, ROWS, ROWS, ROWS]
    c.simulate.restype = None
    c.fit.argtypes = [i, i, i, f, f, *[ROWS] * 9, f, i, ROWS]
    c.fit.restype = i
    return c


def residual(a: Arrays, numbers: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Weighted residual of the free run."""
    angle = np.empty(len(a.command))
    library().simulate(len(angle), a.substeps, TRUTH.gain, a.step, a.command, np.log(numbers), first.copy(), angle)
    return a.weight * (angle - a.reading)


class Fitter:
    """A log laid out in windows; `fit` starts from any numbers."""

    def __init__(self, a: Arrays, samples: int = SAMPLES) -> None:
        n = len(a.command)
        self.windows = -(-n // (samples * LANES)) * LANES
        self.arrays, self.samples = a, samples
        starts = np.minimum(np.arange(self.windows) * samples, n - 1)
        self.nodes = first_states(a.reading, starts)
        self.nodes[starts == n - 1] = self.nodes[-1]
        self.series = [self._padded(v) for v in (a.command, a.reading, a.weight)]
        self.lanes = [self._by_lane(v) for v in self.series]

    def _padded(self, values: np.ndarray) -> np.ndarray:
        return np.append(values, np.zeros(self.windows * self.samples - len(values)))

    def _by_lane(self, values: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(values.reshape(-1, LANES, self.samples).transpose(0, 2, 1)).ravel()

    def fit(self, believed: np.ndarray) -> Found:
        """The optimum from a start."""
        a, z, cost = self.arrays, np.log(believed), np.zeros(1)
        psi, w = (np.ascontiguousarray(v) for v in self.nodes.T)
        evaluations = library().fit(
            self.windows, self.samples, a.substeps, TRUTH.gain, a.step, *self.series, *self.lanes,
            z, psi, w, TOLERANCE, 100, cost,
        )  # fmt: skip
        return Found(np.exp(z), np.array([psi[0], w[0]]), float(cost[0]), int(evaluations))
