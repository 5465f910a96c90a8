"""Steps across kinks: where stick and slip make the sum of squares a valley full of small creases, the exact derivative
points along one crease; differences over a wider span see the valley."""

import numpy as np

from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.problem import Problem
from rwjax.simulation.shooting import free_run

SPANS = (0.03, 0.01, 0.03, 0.01, 0.003)
"""Half spans of the differences, in coordinates (logarithms, or the number's own size)."""
DAMPINGS = (1e-6, 1e-3, 1e-2, 1e-1, 1.0)


def _residual(problem: Problem, theta: np.ndarray, start: np.ndarray) -> np.ndarray:
    y, _ = free_run(problem.structure, theta, start, problem.batch)
    with np.errstate(over="ignore", invalid="ignore"):
        return ((np.asarray(y) - problem.batch.reading) * problem.batch.weight).ravel()


def secant_steps(
    problem: Problem,
    c: Coordinates,
    theta: np.ndarray,
    start: np.ndarray,
    free_start: np.ndarray,
    cost: float,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Gauss-Newton steps with secant derivatives over shrinking spans; keeps only what lowers the cost.

    `free_start`: entries of `start` that move along. Returns numbers, first states and cost.
    """
    entries = np.argwhere(free_start)
    for span in SPANS:
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
        J = np.stack([*columns, *shifts], axis=1)
        if not np.all(np.isfinite(J)):
            break
        H, g = J.T @ J, J.T @ r
        k, slope = np.arange(len(c.index)), c.slope(theta)
        H[k, k] += problem.precision[c.index] * slope**2
        g[k] += problem.prior_cost(theta)[1][c.index] * slope
        scale = np.sqrt(np.maximum(np.diag(H), 1e-300))
        for damping in DAMPINGS:
            M = H / scale / scale[:, None] + damping * np.eye(len(g))
            dz = -np.linalg.lstsq(M, g / scale, rcond=1e-12)[0] / scale
            dz *= c.shorten(dz[: len(c.index)])
            theta_new, start_new = c.move(theta, dz[: len(c.index)]), start.copy()
            for (log, state), d in zip(entries, dz[len(c.index) :], strict=True):
                start_new[log, state] += d
            new = 0.5 * float(np.sum(_residual(problem, theta_new, start_new) ** 2))
            new += problem.prior_cost(theta_new)[0]
            if new < cost:
                theta, start, cost = theta_new, start_new, new
                break
    return theta, start, cost
