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
from rwjax.fitting.gauss_newton import gauss_newton_step
from rwjax.fitting.initial_state_by_secants import initial_states_by_secants, linearised_initial_states, moved_starts
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import Problem
from rwjax.simulation.shooting import Evaluation

SPANS = (0.01, 0.002)
"""Spans of the secants in coordinates (logarithms, or the number's own size), the next one where the last gains nothing."""
DAMPINGS = (1e-6, 1e-2, 1.0, 1e-4, 0.1, 10.0)
"""Levenberg-Marquardt dampings, as many of which are tried at once, three or more, as `MOST_TRIALS` allows."""
MOST_TRIALS = 16
"""Free runs that try one step, where that is not less than three dampings."""
PLACED = 3
"""Trials at most of which the first states are worked out by the start rule until one gains."""


def residuals(problem: Problem, theta: Sequence[np.ndarray], start: Sequence[np.ndarray]) -> Simulating[np.ndarray]:
    """Residuals `(b, l, w, q, y)` in units of noise for several parameter vectors and first states."""
    batch, logs = problem.batch, problem.logs_with_readings
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


def search_point(
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
        cost = 0.5 * float(flat @ flat) + problem.prior_cost(theta)[0]
    return cost if np.isfinite(cost) else np.inf


def with_residual(begun: Fit) -> Simulating[Fit]:
    """A point within its bounds, with its residual, first states of logs whose first state follows from their start by the start rule."""
    problem, theta, start = begun.problem, begun.coordinates.clip(begun.theta), begun.start
    if problem.initial_state_from_start.any():
        ruled = yield from initial_states_by_secants(problem, theta, start)
        start = np.where(problem.initial_state_from_start[:, None], ruled, start)
    residual = (yield from residuals(problem, [theta], [start]))[0]
    return search_point(problem, begun.coordinates, theta, start, residual)


def with_derivatives(begun: Fit) -> Simulating[Fit]:
    """A point of a search with its derivatives."""
    c, theta, start = begun.coordinates, begun.theta, begun.start
    e = yield from slopes(begun.problem, c, theta, start, begun.evaluation.residual, SPANS[-1])
    return replace(begun, evaluation=e)


def descend(here: Fit, *, most_steps: int, tolerance: float) -> Simulating[Fit]:
    """Gauss-Newton steps with secants from a placed point, several dampings of each tried at once; only what lowers the cost
    is kept."""
    problem, c = here.problem, here.coordinates
    k, spans, taken, converged = len(c.index), list(SPANS), 0, False
    dampings = DAMPINGS[: max(3, MOST_TRIALS // max(len(problem.logs_with_readings), 1))]
    while taken < most_steps and np.isfinite(here.cost):
        taken += 1
        e = yield from slopes(problem, c, here.theta, here.start, here.evaluation.residual, spans[0])
        thetas, starts = [], []
        for damping in dampings:
            if (solved := gauss_newton_step(problem, e, c, here.theta, damping)) is not None:
                dz, dx = solved
                share = c.shorten(dz)
                thetas.append(c.move(here.theta, share * dz))
                starts.append(here.start + share * dx)
        gain = 0.0
        if thetas:
            found = yield from residuals(problem, thetas, starts)
            ends = [linearised_initial_states(problem, e.local[k:], x, r) for x, r in zip(starts, found, strict=True)]
            tried = [search_point(problem, c, theta, *end) for theta, end in zip(thetas, ends, strict=True)]
            for trial in sorted(tried, key=lambda f: f.cost)[:PLACED]:
                if trial.cost >= here.cost:
                    break
                best = (yield from with_residual(trial)) if problem.initial_state_from_start.any() else trial
                if best.cost < here.cost:
                    gain, here = here.cost - best.cost, best
                    break
        if gain <= tolerance * max(here.cost, 1.0):
            if len(spans) == 1:
                converged = True
                break
            spans.pop(0)
    return replace(here, converged=converged, steps=taken)
