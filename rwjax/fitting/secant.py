"""Fits by secants: batched free runs alone, with no derivative to compile.

A search tries dozens of structures for a few steps each. Making the program of a structure's derivatives takes longer than its
whole search; that of its free runs takes a third of that, and 16 runs in one call take a third of the time of 16 calls. Secants
over finite spans also follow the valley of a cost that stick-slip makes nonsmooth.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax.fitting.batched_runs import Simulating, Wanted
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.gauss_newton import gauss_newton_steps
from rwjax.fitting.initial_state import initial_states_by_rule, linearised_initial_states, moved_starts
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import Problem
from rwjax.simulation.shooting import Evaluation

SPANS = (0.01, 0.002)
"""Spans of the secants in coordinates (logarithms, or shares of the number's own size) [1].

The next one follows where the last one gains nothing.
"""
WITHOUT_TRACE = 0.2
"""Span where a shorter one changes no reading: the cost of a threshold is flat between two commands that occur [1]."""
DAMPINGS = (1e-6, 1e-2, 1.0, 1e-4, 0.1, 10.0)
"""Levenberg-Marquardt dampings [1], of which at least three are tried at once, and more as `MOST_TRIALS` allows."""
MOST_TRIALS = 16
"""Free runs that try one step, where that allows at least three dampings."""
MOST_EXACT = 3
"""Trials at most whose initial states are estimated from their start to the end, until one of them gains."""


def residuals(problem: Problem, theta: Sequence[np.ndarray], start: Sequence[np.ndarray]) -> Simulating[np.ndarray]:
    """Residuals of several free runs of all logs.

    Args:
        problem: Logs and structure.
        theta: `b` parameter vectors `(t,)` [SI].
        start: As many initial states `(l, n)` [SI].

    Yields:
        Free runs to simulate.

    Returns:
        Residuals in units of noise `(b, l, w, q, y)` [1].
    """
    batch, logs = problem.batch, problem.logs_with_readings
    if not len(logs):
        return np.zeros((len(theta), *batch.reading.shape))
    windows = problem.windows_with_readings
    y = yield Wanted(problem, np.stack(theta), np.stack(start), logs, windows)
    with np.errstate(over="ignore", invalid="ignore"):
        for k, log in enumerate(
            logs
        ):  # where some logs alone are simulated, numpy would copy their readings every time
            y[:, k] -= batch.reading[log, :windows]
            y[:, k] *= batch.weight[log, :windows]
    if y.shape[1:] == batch.reading.shape:
        return y
    found = np.zeros((len(theta), *batch.reading.shape))
    found[:, logs, :windows] = y
    return found


def _moved_numbers(c: Coordinates, theta: np.ndarray, span: float) -> tuple[list[np.ndarray], np.ndarray]:
    """Parameter vectors with one coordinate moved by `span`, away from its bound, and how far each number has moved."""
    k, thetas = len(c.index), []
    for j in range(k):
        step = np.zeros(k)
        step[j] = span
        up, down = c.move(theta, step), c.move(theta, -step)
        thetas.append(up if abs(up - theta)[c.index[j]] >= abs(down - theta)[c.index[j]] else down)
    return thetas, np.array([(thetas[j] - theta)[c.index[j]] for j in range(k)])


def slopes(
    problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, residual: np.ndarray, span: float
) -> Simulating[Evaluation]:
    """Secants from a point whose residual is known, in the form of `evaluate`; a number that leaves no trace is moved further.

    Args:
        problem: Logs and structure.
        c: The free numbers.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI].
        residual: Residual there in units of noise `(l, w, q, y)` [1].
        span: Span of the secants in coordinates [1].

    Yields:
        Free runs to simulate.

    Returns:
        Residual and derivatives; those of every window are by the log's initial state.
    """
    k, n = len(c.index), start.shape[1]
    thetas, change = _moved_numbers(c, theta, span)
    states, width, moved = moved_starts(problem, start)
    local = np.zeros((k + n, *residual.shape))
    if k + len(states):
        r = yield from residuals(problem, [*thetas, *[theta] * len(states)], [*[start] * k, *moved])
        flat = [j for j in range(k) if change[j] != 0.0 and np.array_equal(r[j], residual)]
        if flat:
            further, by = _moved_numbers(c, theta, WITHOUT_TRACE)
            r[flat] = yield from residuals(problem, [further[j] for j in flat], [start] * len(flat))
            change[flat] = by[flat]
        with np.errstate(all="ignore"):
            r -= residual
            r[:k] *= np.where(change == 0.0, 0.0, 1.0 / change)[:, None, None, None, None]
            r[k:] /= width.T[states][..., None, None, None]
        if len(states) == n:
            local = r
        else:
            local[[*range(k), *(k + states)]] = r
    return _evaluation(local, residual, n)


def _evaluation(local: np.ndarray, residual: np.ndarray, n: int) -> Evaluation:
    """`Evaluation` of derivatives through the whole run by (numbers, initial state); `local` is changed.

    A derivative whose square is not finite, of a run that leaves the range of numbers, is 0: its number is not moved.
    """
    columns, L, windows = len(local), *residual.shape[:2]
    k = columns - n
    chain = np.zeros((L, windows, n, columns))
    chain[..., k:] = np.eye(n)
    with np.errstate(over="ignore", invalid="ignore"):
        by_log = np.moveaxis(local.reshape(columns, L, -1), 1, 0)
        H = by_log @ np.swapaxes(by_log, 1, 2)
        beyond = ~np.isfinite(np.einsum("lkk->k", H))
        if beyond.any():
            local[beyond] = 0.0
            by_log = np.moveaxis(local.reshape(columns, L, -1), 1, 0)
            H = by_log @ np.swapaxes(by_log, 1, 2)
        g = (by_log @ residual.reshape(L, -1, 1))[..., 0]
    return Evaluation(residual, local, chain, np.zeros((L, windows, n)), H, g, np.zeros_like(chain[..., 0]))


def search_point(
    problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, residual: np.ndarray | None = None
) -> Fit:
    """A point of a search, as a fit of no step and without derivatives.

    Args:
        problem: Logs and structure.
        c: The free numbers.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI].
        residual: Residual there in units of noise `(l, w, q, y)` [1], where it is known.

    Returns:
        The point; its cost is infinite where its residual is not known.
    """
    none = np.zeros(0)
    e = Evaluation(none if residual is None else residual, none, none, none, none, none, none)
    return Fit(problem, c, theta, start, _cost(problem, theta, residual), e, False, 0)


def _cost(problem: Problem, theta: np.ndarray, residual: np.ndarray | None) -> float:
    """Half the sum of squares of a residual, and the prior's share; infinite where there is none."""
    if residual is None:
        return np.inf
    with np.errstate(over="ignore", invalid="ignore"):
        flat = residual.ravel()
        cost = 0.5 * float(flat @ flat) + problem.prior_cost(theta)[0]
    return cost if np.isfinite(cost) else np.inf


def with_residual(here: Fit) -> Simulating[Fit]:
    """A point moved into its bounds, with its residual, and with initial states from the start where the problem says so.

    Args:
        here: The point.

    Yields:
        Free runs to simulate.

    Returns:
        The point with its residual and cost.
    """
    problem, theta, start = here.problem, here.coordinates.clip(here.theta), here.start
    start = yield from initial_states_by_rule(problem, theta, start)
    residual = (yield from residuals(problem, [theta], [start]))[0]
    return search_point(problem, here.coordinates, theta, start, residual)


def with_derivatives(here: Fit) -> Simulating[Fit]:
    """A point with its secants over the narrowest span.

    Args:
        here: A point with its residual.

    Yields:
        Free runs to simulate.

    Returns:
        The point with its derivatives.
    """
    c, theta, start = here.coordinates, here.theta, here.start
    e = yield from slopes(here.problem, c, theta, start, here.evaluation.residual, SPANS[-1])
    return replace(here, evaluation=e)


def _trials(here: Fit, e: Evaluation) -> Simulating[list[Fit]]:
    """Points after one step with each of several dampings, the lowest cost first; initial states to first order."""
    problem, c, k = here.problem, here.coordinates, len(here.coordinates.index)
    thetas, starts = [], []
    dampings = DAMPINGS[: max(3, MOST_TRIALS // max(len(problem.logs_with_readings), 1))]
    for step in gauss_newton_steps(problem, e, c, here.theta, dampings):
        if step is not None:
            dz, dx = step
            share = c.shorten(dz)
            thetas.append(c.move(here.theta, share * dz))
            starts.append(here.start + share * dx)
    if not thetas:
        return []
    found = yield from residuals(problem, thetas, starts)
    ends = [linearised_initial_states(problem, e.local[k:], x, r) for x, r in zip(starts, found, strict=True)]
    tried = [search_point(problem, c, theta, *end) for theta, end in zip(thetas, ends, strict=True)]
    return sorted(tried, key=lambda f: f.cost)


def step_by_slopes(here: Fit, slopes_nearby: Evaluation) -> Simulating[Fit]:
    """A point after one Gauss-Newton step by the slopes of another point.

    Args:
        here: The point.
        slopes_nearby: What `slopes` gives at the other one, by the coordinates of `here`.

    Yields:
        Free runs to simulate.

    Returns:
        The point with its residual, or where several dampings lead from it, whichever costs least.
    """
    here = yield from with_residual(here)
    residual, local = here.evaluation.residual, slopes_nearby.local
    g = np.einsum("klm,lm->lk", local.reshape(*local.shape[:2], -1), residual.reshape(len(residual), -1))
    trials = yield from _trials(here, slopes_nearby._replace(residual=residual, g=g))
    return min([here, *trials], key=lambda f: f.cost)


def _first_better(here: Fit, trials: Sequence[Fit]) -> Simulating[Fit]:
    """The first trial that costs less than the present point once its initial states are exact, or the point itself."""
    for trial in trials:
        if trial.cost >= here.cost:
            break
        best = (yield from with_residual(trial)) if here.problem.initial_state_from_start.any() else trial
        if best.cost < here.cost:
            return best
    return here


def descend(here: Fit, *, most_steps: int, tolerance: float, spans: Sequence[float] = SPANS) -> Simulating[Fit]:
    """Gauss-Newton steps with secants, each with several dampings at once; only what lowers the cost is kept.

    Args:
        here: A point with its residual.
        most_steps: Steps at most [1].
        tolerance: Share of the cost below which a step's gain leads to the next span, and after the last one ends the
            search [1].
        spans: Spans of the secants in coordinates, one after the other [1].

    Yields:
        Free runs to simulate.

    Returns:
        The last point, without derivatives.
    """
    remaining, taken, converged = list(spans), 0, False
    while taken < most_steps and np.isfinite(here.cost):
        taken += 1
        e = yield from slopes(
            here.problem, here.coordinates, here.theta, here.start, here.evaluation.residual, remaining[0]
        )
        before = here.cost
        here = yield from _first_better(here, (yield from _trials(here, e))[:MOST_EXACT])
        if before - here.cost <= tolerance * max(here.cost, 1.0):
            if len(remaining) == 1:
                converged = True
                break
            remaining.pop(0)
    return replace(here, converged=converged, steps=taken)
