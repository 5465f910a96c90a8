"""What the first 0.5 s of a run tell of its first state."""

import numpy as np

from rwjax.fitting.gauss_newton import LARGEST_DAMPING, initial_state_response
from rwjax.fitting.initial_guess import START_S
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import run_costs, sensitivities
from rwjax.simulation.batch import by_sample


def initial_state_covariance(problem: Problem, by_state: np.ndarray, log: int) -> np.ndarray:
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


START_STEPS = 12


def initial_states_by_sensitivities(problem: Problem, theta: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """First state of each log `(l, n)` by the start rule: least squares over its first 0.5 s, every log for itself."""
    x = problem.start if start is None else start
    early = problem.start_only
    told = early.batch.weight.any(axis=(1, 2, 3)) & problem.start_free.any(axis=1)
    if not told.any():
        return x
    nothing = np.zeros(0, int)
    cost, nodes = run_costs(early, theta, x)
    damping = np.full(len(x), 1e-3)
    settled = ~told
    for _ in range(START_STEPS):
        e = sensitivities(early, theta, nothing, nodes)
        p = e.g.shape[1] - x.shape[1]
        trial = x.copy()
        for log in np.flatnonzero(~settled & np.isfinite(e.g).all(axis=1)):
            s = np.flatnonzero(problem.start_free[log])
            trial[log, s] += initial_state_response(e.H[log], e.g[log], nothing, p + s, damping[log])[1]
        cost_new, nodes_new = run_costs(early, theta, trial)
        better = np.isfinite(cost_new) & (cost_new <= cost)
        gain = np.where(better, cost, 0.0) - np.where(better, cost_new, 0.0)  # of runs that leave the range: none
        settled |= better & (gain <= 1e-5 * np.maximum(cost, 1.0))
        damping = np.where(better, np.maximum(0.1 * damping, 1e-10), 8.0 * np.maximum(damping, 1e-6))
        settled |= damping > LARGEST_DAMPING
        x, cost = np.where(better[:, None], trial, x), np.where(better, cost_new, cost)
        nodes = np.where(better[:, None, None], nodes_new, nodes)
        if settled.all():
            break
    return x
