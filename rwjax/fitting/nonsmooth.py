"""Secant steps for a nonsmooth cost.

Stick-slip makes the sum of squares nonsmooth: the exact derivative at a point describes only its neighbourhood.
Differences over a wider span show how the cost falls over the whole valley.
"""

import numpy as np

from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.problem import Problem
from rwjax.simulation.free_run import free_run

SPANS = (0.03, 0.01, 0.03, 0.01, 0.003)
"""Half spans of the differences, in coordinates: logarithms, or shares of the number's own size [1]."""
DAMPINGS = (1e-6, 1e-3, 1e-2, 1e-1, 1.0)
"""Levenberg-Marquardt dampings, tried in this order until one lowers the cost [1]."""


def _residual(problem: Problem, theta: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Residual of the free run in units of noise, flat."""
    y, _ = free_run(problem.structure, theta, start, problem.batch, stepper=problem.stepper)
    with np.errstate(over="ignore", invalid="ignore"):
        return ((np.asarray(y) - problem.batch.reading) * problem.batch.weight).ravel()


def _secants(
    problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, entries: np.ndarray, span: float
) -> tuple[np.ndarray, np.ndarray]:
    """Residual and its secants by the coordinates and by some `entries` of the initial states."""
    r = _residual(problem, theta, start)
    columns = []
    for k in range(len(c.index)):
        d = np.zeros(len(c.index))
        d[k] = span
        up, down = c.move(theta, d), c.move(theta, -d)
        width = float(((up - down) / c.slope_at(theta))[c.index[k]])
        difference = _residual(problem, up, start) - _residual(problem, down, start)
        columns.append(difference / width if width > 0.0 else np.zeros_like(r))
    shifts = []
    for log, state in entries:
        h = 1e-6 * max(abs(start[log, state]), 1.0)
        moved = start.copy()
        moved[log, state] += h
        shifts.append((_residual(problem, theta, moved) - r) / h)
    return r, np.stack([*columns, *shifts], axis=1)


def secant_steps(
    problem: Problem,
    c: Coordinates,
    theta: np.ndarray,
    start: np.ndarray,
    free_start: np.ndarray,
    cost: float,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Gauss-Newton steps with secants over shrinking spans; only steps that lower the cost are kept.

    Args:
        problem: Logs and structure.
        c: The free numbers.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI].
        free_start: Entries of `start` that are estimated along `(l, n)` [true or false].
        cost: Cost at this point [1].

    Returns:
        Parameter vector `(t,)` [SI], initial states `(l, n)` [SI] and cost [1] of the best point.
    """
    entries, free = np.argwhere(free_start), len(c.index)
    for span in SPANS:
        r, J = _secants(problem, c, theta, start, entries, span)
        if not np.all(np.isfinite(J)):
            break
        H, g = J.T @ J, J.T @ r
        k, slope = np.arange(free), c.slope(theta)
        H[k, k] += problem.precision[c.index] * slope**2
        g[k] += problem.prior_cost(theta)[1][c.index] * slope
        scale = np.sqrt(np.maximum(np.diag(H), 1e-300))
        for damping in DAMPINGS:
            M = H / scale / scale[:, None] + damping * np.eye(len(g))
            dz = -np.linalg.lstsq(M, g / scale, rcond=1e-12)[0] / scale
            dz *= c.shorten(dz[:free])
            theta_new, start_new = c.move(theta, dz[:free]), start.copy()
            for (log, state), d in zip(entries, dz[free:], strict=True):
                start_new[log, state] += d
            new = 0.5 * float(np.sum(_residual(problem, theta_new, start_new) ** 2))
            new += problem.prior_cost(theta_new)[0]
            if new < cost:
                theta, start, cost = theta_new, start_new, new
                break
    return theta, start, cost
