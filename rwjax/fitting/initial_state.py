"""Initial states from the first 0.5 s of each run: least squares by exact sensitivities, and its covariance."""

import numpy as np

from rwjax.fitting.gauss_newton import LARGEST_DAMPING, initial_state_response
from rwjax.fitting.initial_guess import first_half_second
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import run_costs, sensitivities

MOST_STEPS = 12
"""Gauss-Newton steps at most towards the initial states."""


@np.errstate(over="ignore", invalid="ignore")  # of a run that leaves the range of numbers nothing is known
def initial_state_covariance(problem: Problem, by_state: np.ndarray, log: int) -> np.ndarray:
    """Covariance of a log's initial state from the readings of its first 0.5 s.

    Args:
        problem: Logs and structure.
        by_state: Derivative of the log's residual by its initial state `(w, q, y, n)` [1/SI].
        log: Number of the log.

    Returns:
        Covariance `(n, n)` [SI²], 0 for known entries.
    """
    s = np.flatnonzero(problem.start_free[log])
    n = by_state.shape[-1]
    covariance = np.zeros((n, n))
    if not len(s):
        return covariance
    record, sample = problem.logs[log], problem.batch.slot_sample[log]
    first = (sample >= 0) & first_half_second(record)[sample]
    logged = [name in record.outputs for name in problem.structure.outputs]
    G = by_state[first][:, logged].reshape(-1, n)[:, s]
    H = G.T @ G
    scale = np.sqrt(np.maximum(np.diag(H), 1e-300))
    covariance[np.ix_(s, s)] = (
        np.linalg.pinv(H / scale / scale[:, None], rcond=1e-10, hermitian=True) / scale / scale[:, None]
    )
    return covariance


def initial_states_by_sensitivities(problem: Problem, theta: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """Initial state of each log: least squares over its first 0.5 s, every log by itself.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI] where the search begins; the problem's own without it.

    Returns:
        Initial states `(l, n)` [SI]; known entries, and logs without readings there, are those of `start`.
    """
    x = problem.start if start is None else start
    early = problem.start_only
    sought = early.batch.weight.any(axis=(1, 2, 3)) & problem.start_free.any(axis=1)
    if not sought.any():
        return x
    nothing = np.zeros(0, int)
    cost, nodes = run_costs(early, theta, x)
    damping = np.full(len(x), 1e-3)
    done = ~sought
    for _ in range(MOST_STEPS):
        e = sensitivities(early, theta, nothing, nodes)
        p = e.g.shape[1] - x.shape[1]
        trial = x.copy()
        for log in np.flatnonzero(~done & np.isfinite(e.g).all(axis=1)):
            s = np.flatnonzero(problem.start_free[log])
            trial[log, s] += initial_state_response(e.H[log], e.g[log], nothing, p + s, damping[log])[1]
        cost_new, nodes_new = run_costs(early, theta, trial)
        better = np.isfinite(cost_new) & (cost_new <= cost)
        gain = np.where(better, cost, 0.0) - np.where(better, cost_new, 0.0)  # 0 for runs that leave the range
        done |= better & (gain <= 1e-5 * np.maximum(cost, 1.0))
        damping = np.where(better, np.maximum(0.1 * damping, 1e-10), 8.0 * np.maximum(damping, 1e-6))
        done |= damping > LARGEST_DAMPING
        x, cost = np.where(better[:, None], trial, x), np.where(better, cost_new, cost)
        nodes = np.where(better[:, None, None], nodes_new, nodes)
        if done.all():
            break
    return x
