"""Initial states from the first 0.5 s of each run, by secants of batched free runs, and their covariance."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.fitting.batched_runs import Simulating, Wanted
from rwjax.fitting.initial_guess import first_half_second
from rwjax.fitting.problem import Problem

START_SPAN = 1e-4
"""Span of a secant by an entry of an initial state, in its SI unit or as a share of its size, whichever is larger."""
MOST_STEPS = 12
"""Steps at most towards the initial states."""
LEAST_FORETOLD, LEAST_MADE = 1e-8, 1e-6
"""Shares of the sum of squares below which a step's gain, foretold or made, ends the search [1]: along a kink, steps gain little for long."""
DAMPINGS = (0.0, 1e-3, 0.1, 10.0, 1e3)
"""Levenberg-Marquardt dampings [1]. Once a log's whole step has not gained, its steps are tried with all of them side by side."""


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


class _Step(NamedTuple):
    """The step that minimises a residual to first order, by the singular values of its scaled columns.

    Attributes:
        directions: Changes of the unknowns `(k, n)` that move the residual each by its singular value [SI].
        size: The singular values `(k,)` [1]; those that are none but for rounding are left out.
        along: Share of the residual along each of them `(k,)` [1].
    """

    directions: np.ndarray
    size: np.ndarray
    along: np.ndarray

    @property
    def foretold(self) -> float:
        """By how much the whole step lessens the sum of squares to first order [1]."""
        return float(self.along @ self.along)

    def change(self, damping: float) -> np.ndarray:
        """Change of the unknowns `(n,)` [SI] with a damping [1]."""
        return -(self.along * self.size / (self.size**2 + damping)) @ self.directions


def _step(columns: np.ndarray, residual: np.ndarray) -> _Step:
    """The step for columns `(m, n)` and a residual `(m,)`; an unknown whose column is 0 or not finite stays, all where the residual is not finite."""
    with np.errstate(over="ignore"):
        scale = np.sqrt(np.sum(columns**2, axis=0))
    seen = (scale > 1e-140) & np.isfinite(scale)
    if not (seen.any() and np.all(np.isfinite(residual))):
        return _Step(np.zeros((0, len(scale))), np.zeros(0), np.zeros(0))
    u, size, v = np.linalg.svd(columns[:, seen] / scale[seen], full_matrices=False)
    kept = size > 1e-9 * size[0]
    directions = np.zeros((int(kept.sum()), len(scale)))
    directions[:, seen] = v[kept] / scale[seen]
    return _Step(directions, size[kept], residual @ u[:, kept])


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
        change = _step(columns, unit * residual[log, : early.windows][seen]).change(0.0)
        start[log, s] += change
        residual[log] += np.tensordot(change, G, axes=1)
    return start, residual


class _Early(NamedTuple):
    """A log's first 0.5 s: the step to a better initial state, in its free entries, and the sum of squares [1]."""

    step: _Step
    square: float


def _residuals(
    problem: Problem, theta: np.ndarray, starts: Sequence[np.ndarray], logs: np.ndarray
) -> Simulating[tuple[np.ndarray, np.ndarray]]:
    """Residuals `(b, l, m)` of the first 0.5 s of some logs from several initial states, and their sums of squares `(b, l)`."""
    early = problem.start_only.batch
    y = yield Wanted(problem, np.tile(theta, (len(starts), 1)), np.stack(starts), logs, early.windows)
    with np.errstate(over="ignore", invalid="ignore"):
        r = ((y - early.reading[logs]) * early.weight[logs]).reshape(len(y), len(logs), -1)
        square = np.einsum("blm,blm->bl", r, r)
    return r, np.where(np.isfinite(square), square, np.inf)


def _early_runs(
    problem: Problem, theta: np.ndarray, start: np.ndarray, logs: np.ndarray
) -> Simulating[dict[int, _Early]]:
    """The first 0.5 s of some logs, by log number."""
    states, width, moved = moved_starts(problem, start)
    r, square = yield from _residuals(problem, theta, [start, *moved], logs)
    found = {}
    for k, log in enumerate(map(int, logs)):
        free = problem.start_free[log][states]
        with np.errstate(over="ignore", invalid="ignore"):
            columns = (r[1:, k][free] - r[0, k]) / width[log, states[free]][:, None]
        found[log] = _Early(_step(columns.T, r[0, k]), float(square[0, k]))
    return found


def initial_states(
    problem: Problem, theta: np.ndarray, start: np.ndarray | None = None, logs: np.ndarray | None = None
) -> Simulating[np.ndarray]:
    """Initial state of each log: least squares over its first 0.5 s, every log by itself.

    Nothing after the first 0.5 s is simulated.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI] where the search begins; the problem's own without it.
        logs: Numbers of the logs whose initial states are sought [1]; all without it.

    Yields:
        Free runs to simulate.

    Returns:
        Initial states `(l, n)` [SI]; known entries, and logs without readings there or not sought, are those of `start`.
    """
    start = (problem.start if start is None else start).copy()
    told = problem.start_free.any(axis=1) & problem.start_only.batch.weight.any(axis=(1, 2, 3))
    wanted = np.flatnonzero(told) if logs is None else np.intersect1d(np.flatnonzero(told), logs)
    here = (yield from _early_runs(problem, theta, start, wanted)) if len(wanted) else {}
    damped: set[int] = set()
    for _ in range(MOST_STEPS):
        here = {log: one for log, one in here.items() if one.step.foretold > LEAST_FORETOLD * max(one.square, 1.0)}
        if not here:
            break
        whole = {log: one for log, one in here.items() if log not in damped}
        trial, tried = _moved(problem, start, whole, 0.0), dict[int, _Early]()
        if whole:
            tried = yield from _early_runs(problem, theta, trial, np.array([*whole]))
            damped |= {log for log in whole if not tried[log].square < here[log].square}
        if again := {log: one for log, one in here.items() if log in damped}:
            trial, found = yield from _by_dampings(problem, theta, start, trial, again)
            tried |= found
        going_on = {}
        for log, before in here.items():
            if log in tried and tried[log].square < before.square:
                start[log] = trial[log]
                if before.square - tried[log].square > LEAST_MADE * max(before.square, 1.0):
                    going_on[log] = tried[log]
        here = going_on
    return start


def _by_dampings(
    problem: Problem, theta: np.ndarray, start: np.ndarray, trial: np.ndarray, those: dict[int, _Early]
) -> Simulating[tuple[np.ndarray, dict[int, _Early]]]:
    """Trial states with those of some logs moved by the best of all dampings, and the runs from there of the logs that gain."""
    logs, trial = np.array([*those]), trial.copy()
    trials = [_moved(problem, start, those, damping) for damping in DAMPINGS]
    _, square = yield from _residuals(problem, theta, trials, logs)
    for k, log in enumerate(logs):
        trial[log] = trials[int(np.argmin(square[:, k]))][log]
    gains = [log for k, log in enumerate(logs) if square[:, k].min() < those[log].square]
    return trial, ((yield from _early_runs(problem, theta, trial, np.array(gains))) if gains else {})


def initial_states_by_rule(problem: Problem, theta: np.ndarray, start: np.ndarray) -> Simulating[np.ndarray]:
    """Initial states, anew for the logs that the problem takes from their first 0.5 s.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI] where the search begins.

    Yields:
        Free runs to simulate.

    Returns:
        Initial states `(l, n)` [SI].
    """
    logs = np.flatnonzero(problem.initial_state_from_start)
    return (yield from initial_states(problem, theta, start, logs)) if len(logs) else start


def _moved(problem: Problem, start: np.ndarray, those: dict[int, _Early], damping: float) -> np.ndarray:
    """Initial states `(l, n)` [SI] with those of some logs moved by their step with a damping [1]."""
    moved = start.copy()
    for log, early in those.items():
        moved[log, problem.start_free[log]] += early.step.change(damping)
    return moved


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
