"""TODO."""

import numpy as np

from rwjax.fitting.batched_runs import Simulating, Wanted
from rwjax.fitting.problem import Problem

START_SPAN = 1e-4
"""Span by a first state, in its unit or as a share of its size."""
MOST_SETTLING, SETTLED, LEAST_DAMPING, MOST_DAMPING = 30, 1e-8, 1e-12, 1e6
"""Steps towards the start rule's first states at most, the gain, as a share of the sum of squares, that ends them, and
dampings between which they go."""


def moved_starts(problem: Problem, start: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """States of which some log does not know the first, the spans `(l, n)` by which they are moved, and first states with
    one after the other moved."""
    states = np.flatnonzero(problem.start_free.any(axis=0))
    width = START_SPAN * np.maximum(np.abs(start), 1.0)
    return states, width, [start + width * (np.arange(start.shape[1]) == s) for s in states]


def linearised_initial_states(
    problem: Problem, by_state: np.ndarray, start: np.ndarray, residual: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """First states of logs whose first state follows from their start by the start rule and the residual there, to first order; `by_state` (n, l, …)."""
    if not problem.initial_state_from_start.any():
        return start, residual
    early = problem.start_only.batch
    start, residual = start.copy(), residual.copy()
    for log in np.flatnonzero(problem.initial_state_from_start):
        s = np.flatnonzero(problem.start_free[log])
        G = by_state[s, log]
        seen = early.weight[log] > 0.0
        unit = early.weight[log][seen] / problem.batch.weight[log, : early.windows][seen]
        columns = G[:, : early.windows][:, seen].T * unit[:, None]
        change = _least_squares(columns, unit * residual[log, : early.windows][seen], 0.0)
        start[log, s] += change
        residual[log] += np.tensordot(change, G, axes=1)
    return start, residual


def _least_squares(columns: np.ndarray, residual: np.ndarray, damping: float) -> np.ndarray:
    """What to change, by these columns, a residual for it to be least; 0 for what it does not depend on or is no number."""
    scale = np.sqrt(np.maximum(np.sum(columns**2, axis=0), 1e-300))
    if not (np.all(np.isfinite(scale)) and np.all(np.isfinite(residual))):
        return np.zeros(len(scale))
    rows = np.concatenate([columns / scale, np.sqrt(damping) * np.eye(len(scale))])
    share = np.linalg.lstsq(rows, np.append(-residual, np.zeros(len(scale))), rcond=1e-9)[0]
    return np.where(scale > 1e-140, share / scale, 0.0)


def initial_states_by_secants(
    problem: Problem, theta: np.ndarray, start: np.ndarray | None = None
) -> Simulating[np.ndarray]:
    """First states by the start rule `(l, n)`, every log for itself; nothing after its first 0.5 s is simulated."""
    start = (problem.start if start is None else start).copy()
    early = problem.start_only.batch

    def seen(trial: np.ndarray, logs: np.ndarray) -> Simulating[dict[int, tuple[np.ndarray, np.ndarray, float]]]:
        """Residual of each log's first 0.5 s, its secants by the first state `(n, …)`, its sum of squares."""
        states, width, moved = moved_starts(problem, trial)
        thetas = np.tile(theta, (1 + len(states), 1))
        y = yield Wanted(problem, thetas, np.stack([trial, *moved]), logs, early.windows)
        with np.errstate(over="ignore", invalid="ignore"):
            r = ((y - early.reading[logs]) * early.weight[logs]).reshape(len(y), len(logs), -1)
            by_state = np.zeros((trial.shape[1], *r.shape[1:]))
            by_state[states] = (r[1:] - r[0]) / width[logs][:, states].T[..., None]
            cost = np.sum(r[0] ** 2, axis=1)
        cost = np.where(np.isfinite(cost), cost, np.inf)
        return {log: (r[0, k], by_state[:, k], float(cost[k])) for k, log in enumerate(map(int, logs))}

    logs = np.flatnonzero(problem.start_free.any(axis=1) & early.weight.any(axis=(1, 2, 3)))
    here = (yield from seen(start, logs)) if len(logs) else {}
    damping = dict.fromkeys(here, LEAST_DAMPING)
    for _ in range(MOST_SETTLING):
        if not damping:
            break
        trial = start.copy()
        for log in damping:
            s = np.flatnonzero(problem.start_free[log])
            residual, by_state, _ = here[log]
            trial[log, s] += _least_squares(by_state[s].T, residual, damping[log])
        tried = yield from seen(trial, np.array(list(damping)))
        for log, there in tried.items():
            gain = here[log][2] - there[2]
            if gain > 0.0:
                start[log], here[log], damping[log] = trial[log], there, LEAST_DAMPING
            else:
                damping[log] = max(damping[log], 1e-4) * 10.0
            if abs(gain) <= SETTLED * max(here[log][2], 1.0) or damping[log] > MOST_DAMPING:
                del damping[log]
    return start
