"""Initial states from the first 0.5 s of each run, by secants of batched free runs."""

from typing import NamedTuple

import numpy as np

from rwjax.fitting.batched_runs import Simulating, Wanted
from rwjax.fitting.problem import Problem

START_SPAN = 1e-4
"""Span of a secant by an entry of an initial state, in its SI unit or as a share of its size, whichever is larger."""
MOST_STEPS = 30
"""Steps at most towards the initial states."""
LEAST_GAIN = 1e-8
"""Share of the sum of squares below which a step's gain ends the search [1]."""
LEAST_DAMPING, MOST_DAMPING = 1e-12, 1e6
"""Range of the Levenberg-Marquardt damping [1]."""


class MovedStarts(NamedTuple):
    """Initial states, moved one entry at a time.

    Attributes:
        states: Numbers of the states whose initial value some log does not know `(s,)`.
        width: By how much each initial state is moved `(l, n)` [SI].
        starts: For each of these states, the initial states of all logs `(l, n)` [SI] with it moved.
    """

    states: np.ndarray
    width: np.ndarray
    starts: list[np.ndarray]


def moved_starts(problem: Problem, start: np.ndarray) -> MovedStarts:
    """Initial states moved for secants.

    Args:
        problem: Logs and structure.
        start: Initial states `(l, n)` [SI].

    Returns:
        The moved initial states.
    """
    states = np.flatnonzero(problem.start_free.any(axis=0))
    width = START_SPAN * np.maximum(np.abs(start), 1.0)
    return MovedStarts(states, width, [start + width * (np.arange(start.shape[1]) == s) for s in states])


def _least_squares(columns: np.ndarray, residual: np.ndarray, damping: float) -> np.ndarray:
    """Change of the unknowns that minimises a residual; 0 where it does not depend on one or is not finite."""
    with np.errstate(over="ignore"):
        scale = np.sqrt(np.maximum(np.sum(columns**2, axis=0), 1e-300))
    if not (np.all(np.isfinite(scale)) and np.all(np.isfinite(residual))):
        return np.zeros(len(scale))
    rows = np.concatenate([columns / scale, np.sqrt(damping) * np.eye(len(scale))])
    share = np.linalg.lstsq(rows, np.append(-residual, np.zeros(len(scale))), rcond=1e-9)[0]
    return np.where(scale > 1e-140, share / scale, 0.0)


@np.errstate(over="ignore", invalid="ignore")  # a run that leaves the range of numbers: its start stays
def linearised_initial_states(
    problem: Problem, by_state: np.ndarray, start: np.ndarray, residual: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Initial states from the first 0.5 s and the residual there, to first order.

    Args:
        problem: Logs and structure, with the logs whose initial state follows from their start.
        by_state: Derivative of the residual by the initial states `(n, l, w, q, y)` [1/SI].
        start: Initial states `(l, n)` [SI].
        residual: Residual there in units of noise `(l, w, q, y)` [1].

    Returns:
        Initial states `(l, n)` [SI] and residual `(l, w, q, y)` [1]; both as they came for all other logs.
    """
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


class _Early(NamedTuple):
    """Residual of a log's first 0.5 s, its secants by the initial state `(n, …)`, and its sum of squares."""

    residual: np.ndarray
    by_state: np.ndarray
    square: float


def _early_runs(
    problem: Problem, theta: np.ndarray, start: np.ndarray, logs: np.ndarray
) -> Simulating[dict[int, _Early]]:
    """The first 0.5 s of some logs, by log number."""
    early = problem.start_only.batch
    states, width, moved = moved_starts(problem, start)
    thetas = np.tile(theta, (1 + len(states), 1))
    y = yield Wanted(problem, thetas, np.stack([start, *moved]), logs, early.windows)
    with np.errstate(over="ignore", invalid="ignore"):
        r = ((y - early.reading[logs]) * early.weight[logs]).reshape(len(y), len(logs), -1)
        by_state = np.zeros((start.shape[1], *r.shape[1:]))
        by_state[states] = (r[1:] - r[0]) / width[logs][:, states].T[..., None]
        square = np.sum(r[0] ** 2, axis=1)
    square = np.where(np.isfinite(square), square, np.inf)
    return {log: _Early(r[0, k], by_state[:, k], float(square[k])) for k, log in enumerate(map(int, logs))}


def initial_states_by_secants(
    problem: Problem, theta: np.ndarray, start: np.ndarray | None = None
) -> Simulating[np.ndarray]:
    """Initial state of each log: least squares over its first 0.5 s, every log by itself.

    Nothing after the first 0.5 s is simulated.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI] where the search begins; the problem's own without it.

    Yields:
        Free runs to simulate.

    Returns:
        Initial states `(l, n)` [SI]; known entries, and logs without readings there, are those of `start`.
    """
    start = (problem.start if start is None else start).copy()
    early = problem.start_only.batch
    logs = np.flatnonzero(problem.start_free.any(axis=1) & early.weight.any(axis=(1, 2, 3)))
    here = (yield from _early_runs(problem, theta, start, logs)) if len(logs) else {}
    damping = dict.fromkeys(here, LEAST_DAMPING)
    for _ in range(MOST_STEPS):
        if not damping:
            break
        trial = start.copy()
        for log in damping:
            s = np.flatnonzero(problem.start_free[log])
            trial[log, s] += _least_squares(here[log].by_state[s].T, here[log].residual, damping[log])
        tried = yield from _early_runs(problem, theta, trial, np.array(list(damping)))
        for log, there in tried.items():
            gain = here[log].square - there.square
            if gain > 0.0:
                start[log], here[log], damping[log] = trial[log], there, LEAST_DAMPING
            else:
                damping[log] = max(damping[log], 1e-4) * 10.0
            if abs(gain) <= LEAST_GAIN * max(here[log].square, 1.0) or damping[log] > MOST_DAMPING:
                del damping[log]
    return start
