"""Screen: what each candidate would remove from the residual at best, from a few free runs and no fit.

At a fitted explanation every candidate is switched on at values from which a search would begin; what that changes in the
free run, and what the free numbers and first states could change, are columns of a least-squares problem in which the
residual is the right side. Free runs at finite values see what a derivative at the null does not (a dead zone, a delay, an
end stop), and small lasting torques that local residuals miss (Breusch and Pagan's score test, with finite probes).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.fit.end_to_end import Fit, by_start, start_normal, start_response
from rwjax.simulate import free_run

LARGEST = 3.0
"""Most by which what a start changes is taken to grow in proportion."""


@dataclass(frozen=True)
class Screened:
    """`left`: half the sum of squares that the best of the starts is predicted to leave; `start`: numbers at which a
    search should begin."""

    left: float
    start: np.ndarray


def _residual(fitted: Fit, theta: np.ndarray) -> np.ndarray:
    y, _ = free_run(fitted.problem.structure, theta, fitted.start, fitted.problem.batch)
    batch = fitted.problem.batch
    with np.errstate(over="ignore", invalid="ignore"):
        return ((np.asarray(y) - batch.reading) * batch.weight).ravel()


class Screen:
    """Predictions around one fit."""

    def __init__(self, fitted: Fit) -> None:
        self.fitted = fitted
        problem, e = fitted.problem, fitted.evaluation
        k, n = np.arange(len(fitted.coordinates.index)), problem.start.shape[1]
        p = len(e.local) - n
        blocks = []
        for log in range(len(problem.logs)):
            s = np.flatnonzero(problem.start_free[log])
            through = by_start(e, log)
            P, _ = start_response(*start_normal(problem, e, log), k, p + s, 0.0)
            blocks.append(through[..., k] + through[..., p + s] @ P)
        self.residual = _residual(fitted, fitted.theta)
        self.basis = self._orthonormal(np.concatenate([b.reshape(-1, len(k)) for b in blocks]))

    @staticmethod
    def _orthonormal(columns: np.ndarray) -> np.ndarray:
        scale = np.sqrt(np.sum(columns**2, axis=0))
        columns = columns[:, scale > 0.0] / scale[scale > 0.0]
        if not columns.shape[1]:
            return columns
        u, s, _ = np.linalg.svd(columns, full_matrices=False)
        return u[:, s > 1e-8 * s[0]]

    def _without(self, column: np.ndarray) -> np.ndarray:
        """A column with what the free numbers can do taken out."""
        return column - self.basis @ (self.basis.T @ column)

    def predict(self, off: np.ndarray, starts: Sequence[np.ndarray]) -> Screened:
        """What an explanation leaves that begins at one of `starts` (t,) and is `off` (t,) where it adds nothing."""
        residual = self.residual if np.array_equal(off, self.fitted.theta) else _residual(self.fitted, off)
        free = self._without(residual)
        best = Screened(0.5 * float(free @ free) if np.all(np.isfinite(free)) else np.inf, starts[0])
        for start in starts:
            column = _residual(self.fitted, start) - residual
            if not np.all(np.isfinite(column)):
                continue
            c = self._without(column)
            power = float(c @ c)
            share = float(np.clip(-(c @ free) / power, 0.0, LARGEST)) if power > 0.0 else 0.0
            left = 0.5 * float(np.sum((free + share * c) ** 2))
            if left < best.left:
                best = Screened(left, start)
        return best
