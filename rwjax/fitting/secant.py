"""Fits by secants: free runs alone, many side by side, with no derivative to be compiled.

A search tries dozens of structures for a few steps each. Compiling exact sensitivities of each takes longer than the
search; a free run is compiled in a second, and 16 side by side take a third of the time of one after the other. Secants
over finite spans also see the valley of a sum of squares that stick and slip fill with creases.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax.fitting.batched_runs import Simulating, Wanted
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.multiple_shooting import Fit, step_of
from rwjax.fitting.problem import Problem
from rwjax.simulation.shooting import Evaluation

SPANS = (0.01, 0.002)
"""Spans of the secants in coordinates (logarithms, or the number's own size), the next one where the last gains nothing."""
START_SPAN = 1e-4
"""Span by a first state, in its unit or as a share of its size."""
DAMPINGS = (1e-6, 1e-2, 1.0, 1e-4, 0.1, 10.0)
"""Levenberg-Marquardt dampings, as many of which are tried at once, three or more, as `MOST_TRIALS` allows."""
MOST_TRIALS = 16
"""Free runs that try one step, where that is not less than three dampings."""
PLACED = 3
"""Trials at most of which the first states are worked out by the start rule until one gains."""
MOST_SETTLING, SETTLED, LEAST_DAMPING, MOST_DAMPING = 30, 1e-8, 1e-12, 1e6
"""Steps towards the start rule's first states at most, the gain, as a share of the sum of squares, that ends them, and
dampings between which they go."""


def residuals(problem: Problem, theta: Sequence[np.ndarray], start: Sequence[np.ndarray]) -> Simulating[np.ndarray]:
    """Residuals `(b, l, w, q, y)` in units of noise for several parameter vectors and first states."""
    batch, logs = problem.batch, problem.told
    if not len(logs):
        return np.zeros((len(theta), *batch.reading.shape))
    windows = int(np.max(batch.windows_of[logs]))
    y = yield Wanted(problem, np.stack(theta), np.stack(start), logs, windows)
    with np.errstate(over="ignore", invalid="ignore"):
        y -= batch.reading[logs, :windows]
        y *= batch.weight[logs, :windows]
    if y.shape[1:] == batch.reading.shape:
        return y
    found = np.zeros((len(theta), *batch.reading.shape))
    found[:, logs, :windows] = y
    return found


def moved_starts(problem: Problem, start: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """States of which some log does not know the first, the spans `(l, n)` by which they are moved, and first states with
    one after the other moved."""
    states = np.flatnonzero(problem.start_free.any(axis=0))
    width = START_SPAN * np.maximum(np.abs(start), 1.0)
    return states, width, [start + width * (np.arange(start.shape[1]) == s) for s in states]


def slopes(
    problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, residual: np.ndarray, span: float
) -> Simulating[Evaluation]:
    """What `evaluate` gives, by secants from a point whose residual is known, every window seen from the log's first
    state."""
    k, (L, n) = len(c.index), start.shape
    thetas = []
    for j in range(k):
        step = np.zeros(k)
        step[j] = span
        up, down = c.move(theta, step), c.move(theta, -step)
        thetas.append(up if abs(up - theta)[c.index[j]] >= abs(down - theta)[c.index[j]] else down)
    states, width, moved = moved_starts(problem, start)
    local = np.zeros((k + n, *residual.shape))
    if k + len(states):
        r = yield from residuals(problem, [*thetas, *[theta] * len(states)], [*[start] * k, *moved])
        change = np.array([(thetas[j] - theta)[c.index[j]] for j in range(k)])
        with np.errstate(all="ignore"):
            r -= residual
            r[:k] *= np.where(change == 0.0, 0.0, 1.0 / change)[:, None, None, None, None]
            r[k:] /= width.T[states][..., None, None, None]
        if len(states) == n:
            local = r
        else:
            local[[*range(k), *(k + states)]] = r
    chain = np.zeros((L, problem.batch.windows, n, k + n))
    chain[..., k:] = np.eye(n)
    with np.errstate(over="ignore", invalid="ignore"):
        by_log = np.moveaxis(local.reshape(k + n, L, -1), 1, 0)
        H = by_log @ np.swapaxes(by_log, 1, 2)
        beyond = ~np.isfinite(np.einsum("lkk->k", H))
        if beyond.any():  # a run that leaves the range of numbers, or whose square does: not moved
            local[beyond] = 0.0
            by_log = np.moveaxis(local.reshape(k + n, L, -1), 1, 0)
            H = by_log @ np.swapaxes(by_log, 1, 2)
        g = (by_log @ residual.reshape(L, -1, 1))[..., 0]
    return Evaluation(
        residual, local, chain, np.zeros((L, problem.batch.windows, n)), H, g, np.zeros_like(chain[..., 0])
    )


def settled(
    problem: Problem, by_state: np.ndarray, start: np.ndarray, residual: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """First states of logs whose first state follows from their start by the start rule and the residual there, to first order; `by_state` (n, l, …)."""
    if not problem.initial_state_from_start.any():
        return start, residual
    early = problem.early.batch
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


def by_start_rule(problem: Problem, theta: np.ndarray, start: np.ndarray | None = None) -> Simulating[np.ndarray]:
    """First states by the start rule `(l, n)`, every log for itself; nothing after its first 0.5 s is simulated."""
    start = (problem.start if start is None else start).copy()
    early = problem.early.batch

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


def point(
    problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, residual: np.ndarray | None = None
) -> Fit:
    """A point of a search, as a fit of no step and without derivatives; its cost is infinite where its residual is not
    known."""
    none = np.zeros(0)
    e = Evaluation(none if residual is None else residual, none, none, none, none, none, none)
    return Fit(problem, c, theta, start, cost_of(problem, theta, residual), e, False, 0)


def cost_of(problem: Problem, theta: np.ndarray, residual: np.ndarray | None) -> float:
    """Half the sum of squares of a residual, and the prior's part; infinite where there is none."""
    if residual is None:
        return np.inf
    with np.errstate(over="ignore", invalid="ignore"):
        flat = residual.ravel()
        cost = 0.5 * float(flat @ flat) + problem.against_prior(theta)[0]
    return cost if np.isfinite(cost) else np.inf


def placed(begun: Fit) -> Simulating[Fit]:
    """A point within its bounds, with its residual, first states of logs whose first state follows from their start by the start rule."""
    problem, theta, start = begun.problem, begun.coordinates.inward(begun.theta), begun.start
    if problem.initial_state_from_start.any():
        ruled = yield from by_start_rule(problem, theta, start)
        start = np.where(problem.initial_state_from_start[:, None], ruled, start)
    residual = (yield from residuals(problem, [theta], [start]))[0]
    return point(problem, begun.coordinates, theta, start, residual)


def derived(begun: Fit) -> Simulating[Fit]:
    """A point of a search with its derivatives."""
    c, theta, start = begun.coordinates, begun.theta, begun.start
    e = yield from slopes(begun.problem, c, theta, start, begun.evaluation.residual, SPANS[-1])
    return replace(begun, evaluation=e)


def descend(here: Fit, *, most_steps: int, tolerance: float) -> Simulating[Fit]:
    """Gauss-Newton steps with secants from a placed point, several dampings of each tried at once; only what lowers the cost
    is kept."""
    problem, c = here.problem, here.coordinates
    k, spans, taken, converged = len(c.index), list(SPANS), 0, False
    dampings = DAMPINGS[: max(3, MOST_TRIALS // max(len(problem.told), 1))]
    while taken < most_steps and np.isfinite(here.cost):
        taken += 1
        e = yield from slopes(problem, c, here.theta, here.start, here.evaluation.residual, spans[0])
        thetas, starts = [], []
        for damping in dampings:
            if (solved := step_of(problem, e, c, here.theta, damping)) is not None:
                dz, dx = solved
                share = c.shorten(dz)
                thetas.append(c.move(here.theta, share * dz))
                starts.append(here.start + share * dx)
        gain = 0.0
        if thetas:
            found = yield from residuals(problem, thetas, starts)
            ends = [settled(problem, e.local[k:], x, r) for x, r in zip(starts, found, strict=True)]
            tried = [point(problem, c, theta, *end) for theta, end in zip(thetas, ends, strict=True)]
            for trial in sorted(tried, key=lambda f: f.cost)[:PLACED]:
                if trial.cost >= here.cost:
                    break
                best = (yield from placed(trial)) if problem.initial_state_from_start.any() else trial
                if best.cost < here.cost:
                    gain, here = here.cost - best.cost, best
                    break
        if gain <= tolerance * max(here.cost, 1.0):
            if len(spans) == 1:
                converged = True
                break
            spans.pop(0)
    return replace(here, converged=converged, steps=taken)
