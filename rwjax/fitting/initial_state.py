"""What the first 0.5 s of a run tell of its first state."""

import numpy as np

from rwjax.fitting.problem import START_S, Problem
from rwjax.simulation.batch import by_sample


def start_covariance(problem: Problem, by_state: np.ndarray, log: int) -> np.ndarray:
    """Covariance `(n, n)` of a log's first state from the readings of its first 0.5 s; `by_state` (w, q, y, n): derivative
    of the log's residual."""
    s = np.flatnonzero(problem.start_free[log])
    n = by_state.shape[-1]
    covariance = np.zeros((n, n))
    if not len(s):
        return covariance
    record, names = problem.logs[log], problem.structure.outputs
    G = by_sample(problem.batch, log, by_state, len(record.time))
    first = record.time - record.time[0] <= START_S
    H = np.zeros((n, n))
    for y, name in enumerate(names):
        if name in record.outputs:
            H += G[first, y].T @ G[first, y]
    H = H[np.ix_(s, s)]
    scale = np.sqrt(np.maximum(np.diag(H), 1e-300))
    covariance[np.ix_(s, s)] = (
        np.linalg.pinv(H / scale / scale[:, None], rcond=1e-10, hermitian=True) / scale / scale[:, None]
    )
    return covariance
