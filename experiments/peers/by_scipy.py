"""scipy: least squares over `solve_ivp`, as most users write it, with four terms."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from experiments.peers.problems import Log, Problem

SAYS = "nothing: the four terms were put in by hand"


def run(p: Problem, z: np.ndarray, log: Log) -> np.ndarray:
    """A free run."""
    h = log.t[1] - log.t[0]

    def rates(time: float, s: np.ndarray) -> list[float]:
        return [s[1], p.acceleration(np, s[0], s[1], log.u[min(int(time / h), len(log.u) - 1)], z)]

    span = (log.t[0], log.t[-1])
    return solve_ivp(rates, span, p.start(log), t_eval=log.t, rtol=1e-6, atol=1e-8, max_step=h).y[p.reads]


def fit(p: Problem) -> np.ndarray:
    """The four numbers, in coarser steps."""
    log = p.train.coarser(p.every)
    return least_squares(lambda z: run(p, z, log) - log.y, _begin(p), diff_step=1e-3, max_nfev=60).x


def _begin(p: Problem) -> np.ndarray:
    return np.array([1.0, 1.0, 1.0, 0.0 if p.gain else 1.0])
