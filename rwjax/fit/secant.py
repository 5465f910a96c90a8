"""Fits by secants: free runs alone, many side by side, with no derivative to be compiled.

A search tries dozens of structures for a few steps each. Compiling exact sensitivities of each takes longer than the
search; a free run is compiled in a second and runs at little more cost with 32 parameter vectors than with one. Secants
over finite spans also see the valley of a sum of squares that stick and slip fill with creases.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax.fit.coordinates import Coordinates
from rwjax.fit.end_to_end import Fit, step_of
from rwjax.fit.problem import Problem
from rwjax.simulate import Evaluation, free_runs

LANES = 32
"""Free runs side by side in one call."""
SPANS = (0.01, 0.002)
"""Spans of the secants in coordinates (logarithms, or the number's own size), the next one where the last gains nothing."""
START_SPAN = 1e-4
"""Span by a first state, in its unit or as a share of its size."""
DAMPINGS = (1e-6, 1e-2, 1.0, 1e-4, 0.1, 10.0)
"""Levenberg-Marquardt dampings, as many of which are tried at once, three or more, as the lanes hold."""
MOST_SETTLING, SETTLED, LEAST_DAMPING, MOST_DAMPING = 30, 1e-10, 1e-12, 1e6
"""Steps towards the start rule's first states at most, the change, as a share of their size, that ends them, and dampings
between which they go."""


def responses(problem: Problem, theta: np.ndarray, start: np.ndarray, logs: np.ndarray) -> np.ndarray:
    """Readings `(b, logs, w, q, y)` of free runs of some logs for parameter vectors (b, t) and first states (b, l, n)."""
    index = np.tile(logs, len(theta))
    values = np.repeat(theta, len(logs), axis=0)
    first = start[:, logs].reshape(len(index), -1)
    found = []
    for begin in range(0, len(index), LANES):
        part = np.minimum(np.arange(begin, begin + LANES), len(index) - 1)  # the last one again fills the lanes
        y = free_runs(problem.structure, values[part], first[part], problem.batch.inputs_of(index[part]))
        found.append(np.asarray(y)[: len(index) - begin])
    y = np.concatenate(found)
    return y.reshape(len(theta), len(logs), *y.shape[1:])


def residuals(problem: Problem, theta: Sequence[np.ndarray], start: Sequence[np.ndarray]) -> np.ndarray:
    """Residuals `(b, l, w, q, y)` in units of noise for several parameter vectors and first states."""
    logs = problem.told
    found = np.zeros((len(theta), *problem.batch.reading.shape))
    if len(logs):
        y = responses(problem, np.stack(theta), np.stack(start), logs)
        with np.errstate(over="ignore", invalid="ignore"):
            found[:, logs] = (y - problem.batch.reading[logs]) * problem.batch.weight[logs]
    return found


def slopes(
    problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, span: float
) -> tuple[Evaluation, np.ndarray]:
    """What `evaluate` gives, by secants, every window seen from the log's first state; and the first states, those of
    anchored logs by the start rule."""
    k, (L, n) = len(c.index), start.shape
    thetas, starts = [theta], [start]
    for j in range(k):
        step = np.zeros(k)
        step[j] = span
        up, down = c.move(theta, step), c.move(theta, -step)
        thetas.append(up if abs(up - theta)[c.index[j]] >= abs(down - theta)[c.index[j]] else down)
        starts.append(start)
    states = np.flatnonzero(problem.start_free.any(axis=0))
    width = START_SPAN * np.maximum(np.abs(start), 1.0)
    for s in states:
        moved = start.copy()
        moved[:, s] += width[:, s]
        thetas.append(theta)
        starts.append(moved)
    r = residuals(problem, thetas, starts)
    local = np.zeros((k + n, *r.shape[1:]))
    with np.errstate(all="ignore"):
        for j in range(k):
            change = (thetas[1 + j] - theta)[c.index[j]]
            local[j] = (r[1 + j] - r[0]) / change if change else 0.0
        for j, s in enumerate(states):
            local[k + s] = (r[1 + k + j] - r[0]) / width[:, s, None, None, None]
    local[~np.isfinite(local).all(axis=(1, 2, 3, 4))] = 0.0  # a run that leaves the range of numbers: not moved
    start, residual = settled(problem, local[k:], start, r[0])
    chain = np.zeros((L, problem.batch.windows, n, k + n))
    chain[..., k:] = np.eye(n)
    flat = local.reshape(k + n, L, -1)
    with np.errstate(over="ignore", invalid="ignore"):
        H = np.einsum("alm,blm->lab", flat, flat, optimize=True)
        g = np.einsum("alm,lm->la", flat, residual.reshape(L, -1))
    none = np.zeros((L, problem.batch.windows, n))
    return Evaluation(residual, local, chain, none, H, g, none), start


def settled(
    problem: Problem,
    by_state: np.ndarray,
    start: np.ndarray,
    residual: np.ndarray,
    damping: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """First states of anchored logs by the start rule and the residual there, to first order; `by_state` (n, l, …),
    `damping` of each log's step (l,)."""
    if not problem.anchored.any():
        return start, residual
    early = problem.early.batch
    start, residual = start.copy(), residual.copy()
    for log in np.flatnonzero(problem.anchored):
        s = np.flatnonzero(problem.start_free[log])
        G = by_state[s, log]
        seen = early.weight[log] > 0.0
        unit = early.weight[log][seen] / problem.batch.weight[log, : early.windows][seen]
        columns = G[:, : early.windows][:, seen].T * unit[:, None]
        scale = np.sqrt(np.maximum(np.sum(columns**2, axis=0), 1e-300))
        held = np.sqrt(damping[log] if damping is not None else 0.0) * np.eye(len(s))
        rows = np.concatenate([columns / scale, held])
        wanted = np.append(-unit * residual[log, : early.windows][seen], np.zeros(len(s)))
        share = np.linalg.lstsq(rows, wanted, rcond=1e-9)[0] / scale
        share = np.where(scale > 1e-140, share, 0.0)
        if np.all(np.isfinite(share)):
            start[log, s] += share
            residual[log] += np.tensordot(share, G, axes=1)
    return start, residual


def by_start_rule(
    problem: Problem, theta: np.ndarray, start: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """First states by the start rule `(l, n)`, every log for itself, and the residual's derivative by them `(n, l, w, q, y)`."""
    start = problem.start if start is None else start
    nothing = Coordinates(np.zeros(0, int), np.zeros(0, bool), np.zeros(0), np.zeros((0, 2)))
    freed = replace(problem, anchored=np.zeros(len(problem.logs), bool))
    damping = np.full(len(problem.logs), LEAST_DAMPING)
    e, _ = slopes(freed, nothing, theta, start, SPANS[-1])
    cost = _early_costs(problem, e.residual)
    for _ in range(MOST_SETTLING):
        trial = settled(problem.by_rule, e.local, start, e.residual, damping)[0]
        change = np.max(np.abs(trial - start) / np.maximum(np.abs(start), 1.0), axis=1)
        if np.all(change < SETTLED):
            break
        tried = _early_costs(problem, residuals(problem, [theta], [trial])[0])
        better = tried < cost
        damping = np.where(better, LEAST_DAMPING, np.maximum(damping, 1e-4) * 10.0)
        if not better.any():
            if np.all(damping > MOST_DAMPING):
                break
            continue
        start = np.where(better[:, None], trial, start)
        e, _ = slopes(freed, nothing, theta, start, SPANS[-1])
        cost = _early_costs(problem, e.residual)
    return start, e.local


def _early_costs(problem: Problem, residual: np.ndarray) -> np.ndarray:
    """Sum of squares of each log's first 0.5 s, every reading by its noise there `(l,)`."""
    early = problem.early.batch
    found = np.zeros(len(residual))
    for log in range(len(residual)):
        seen = early.weight[log] > 0.0
        unit = early.weight[log][seen] / problem.batch.weight[log, : early.windows][seen]
        with np.errstate(over="ignore", invalid="ignore"):
            found[log] = float(np.sum((unit * residual[log, : early.windows][seen]) ** 2))
    return np.where(np.isfinite(found), found, np.inf)


def as_it_is(problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, residual: np.ndarray) -> Fit:
    """A point of a search with its residual and without derivatives, as a fit of no step."""
    none = np.zeros(0)
    e = Evaluation(residual, none, none, none, none, none, none)
    with np.errstate(over="ignore", invalid="ignore"):
        cost = 0.5 * float(np.sum(residual**2)) + problem.against_prior(theta)[0]
    return Fit(problem, c, theta, start, cost if np.isfinite(cost) else np.inf, e, False, 0, 1e-3)


def descend(
    problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, *, most_steps: int, tolerance: float
) -> Fit:
    """Gauss-Newton steps with secants, several dampings of each tried at once; only what lowers the cost is kept."""
    theta = c.inward(theta)
    spans, taken, converged = list(SPANS), 0, False
    dampings = DAMPINGS[: max(3, LANES // max(len(problem.told), 1))]
    if problem.anchored.any():
        start = np.where(problem.anchored[:, None], by_start_rule(problem, theta, start)[0], start)
    e, start = slopes(problem, c, theta, start, spans[0])

    def cost_of(residual: np.ndarray, theta: np.ndarray) -> float:
        with np.errstate(over="ignore", invalid="ignore"):
            cost = 0.5 * float(np.sum(residual**2)) + problem.against_prior(theta)[0]
        return cost if np.isfinite(cost) else np.inf

    cost = cost_of(e.residual, theta)
    while taken < most_steps and np.isfinite(cost):
        taken += 1
        thetas, starts = [], []
        for damping in dampings:
            if (solved := step_of(problem, e, c, theta, damping)) is not None:
                dz, dx = solved
                share = c.shorten(dz)
                thetas.append(c.move(theta, share * dz))
                starts.append(start + share * dx)
        gain = 0.0
        if thetas:
            k = len(c.index)
            found = residuals(problem, thetas, starts)
            ends = [settled(problem, e.local[k:], x, r) for x, r in zip(starts, found, strict=True)]
            costs = [cost_of(r, t) for (_, r), t in zip(ends, thetas, strict=True)]
            best = int(np.argmin(costs))
            gain = cost - costs[best]
            if gain > 0.0:
                theta, start, cost = thetas[best], ends[best][0], costs[best]
        if gain <= tolerance * max(cost, 1.0):
            if len(spans) == 1:
                converged = True
                break
            spans.pop(0)
        e, start = slopes(problem, c, theta, start, spans[0])
        cost = cost_of(e.residual, theta)
    return Fit(problem, c, theta, start, cost, e, converged, taken, 1e-3)
