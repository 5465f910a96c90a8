"""Standard errors that hold with correlated residuals, and what the logs cannot tell, in words."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.effects.library import null_of_optional
from rwjax.fitting.gauss_newton import initial_state_normal, initial_state_response
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.sensitivities import residual_jacobian
from rwjax.simulation.batch import by_sample

UNIDENTIFIED = 1e-8
"""Ratio of the smallest to the largest eigenvalue of the normalised normal equations below which a combination of
numbers is called undetermined."""
WEIGHS = 0.01
"""Weight in an undetermined combination above which a number is undetermined itself."""


TIED = 0.99
"""Correlation above which two numbers are hardly told apart."""


@dataclass(frozen=True)
class Uncertainty:
    """`covariance` (k, k) of the free numbers in SI; rows and columns of numbers on a bound or undetermined are inf.

    `inflation` (k,): by what correlated residuals multiply the variance of each; the mean of the others where a number
    has none. `notes`: what a user should know, one sentence each.
    """

    names: tuple[str, ...]
    covariance: np.ndarray
    inflation: np.ndarray
    notes: tuple[str, ...]

    def of(self, names: Sequence[str]) -> np.ndarray:
        """Covariance of some of the numbers."""
        k = [self.names.index(name) for name in names]
        return self.covariance[np.ix_(k, k)]

    @property
    def standard_error(self) -> dict[str, float]:
        """Standard error of each free number in SI."""
        return dict(zip(self.names, (float(v) for v in np.sqrt(np.diag(self.covariance))), strict=True))


def strongly_tied(found: Uncertainty) -> list[tuple[str, str, float]]:
    """Pairs of numbers whose errors correlate by more than `TIED`, and by how much."""
    d = np.sqrt(np.diag(found.covariance))
    with np.errstate(invalid="ignore"):
        correlation = found.covariance / d / d[:, None]
    pairs = [(i, j) for i in range(len(d)) for j in range(i) if abs(correlation[i, j]) > TIED]
    return [(found.names[j], found.names[i], float(correlation[i, j])) for i, j in pairs]


def scores(fitted: Fit) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """Normal matrix of the free coordinates with first states eliminated, and for each log its reduced Jacobian
    `(time, output, k)` and residual `(time, output)` in units of noise; of the readings alone, without the prior."""
    problem, e, k = fitted.problem, fitted.evaluation, np.arange(len(fitted.coordinates.index))
    p = len(e.local) - problem.start.shape[1]
    scale = fitted.coordinates.slope(fitted.theta)
    A = np.zeros((len(k), len(k)))
    jacobians, residuals = [], []
    for log, record in enumerate(problem.logs):
        s = np.flatnonzero(problem.start_free[log])
        P, _ = initial_state_response(*initial_state_normal(problem, e, log), k, p + s, 0.0)
        through = residual_jacobian(e, log)
        through = (through[..., k] + through[..., p + s] @ P) * scale
        Gt = by_sample(problem.batch, log, through, len(record.time))
        A += np.einsum("tya,tyb->ab", Gt, Gt)
        jacobians.append(Gt)
        residuals.append(by_sample(problem.batch, log, e.residual[log], len(record.time)))
    return A, jacobians, residuals


def _bandwidth(series: np.ndarray) -> float:
    """Bartlett bandwidth in samples by the first-order plug-in of Andrews (Econometrica 59, 1991, eq. 6.4)."""
    num = den = 0.0
    for x in series.T:
        x = x - x.mean()
        power = float(x @ x)
        if power <= 0.0:
            continue
        rho = min(max(float(x[1:] @ x[:-1]) / power, 0.0), 0.999)
        innovation = (1.0 - rho**2) * power / len(x)
        num += 4.0 * rho**2 * innovation**2 / ((1.0 - rho) ** 6 * (1.0 + rho) ** 2)
        den += innovation**2 / (1.0 - rho) ** 4
    return 1.1447 * (num / den * len(series)) ** (1.0 / 3.0) if den > 0.0 else 0.0


def meat(jacobians: list[np.ndarray], residuals: list[np.ndarray]) -> np.ndarray:
    """Long-run covariance of the score summed over logs (Newey and West, Econometrica 55, 1987)."""
    k = jacobians[0].shape[-1]
    total = np.zeros((k, k))
    for G, r in zip(jacobians, residuals, strict=True):
        score = np.einsum("tya,ty->ta", G, r)
        width = min(_bandwidth(score), len(score) / 4.0)
        total += score.T @ score
        n, size = len(score), 1
        while size < 2 * n:
            size *= 2
        spectrum = np.fft.rfft(score, size, axis=0)
        for a in range(k):
            for b in range(k):
                lagged = np.fft.irfft(spectrum[:, a].conj() * spectrum[:, b], size)
                lags = np.arange(1, min(int(np.ceil(width)) + 1, n))  # all of positive weight: no variance is below 0
                weight = 1.0 - lags / (width + 1.0)
                total[a, b] += float(weight @ (lagged[lags] + lagged[-lags]))
    return total


def undetermined(A: np.ndarray) -> np.ndarray:
    """Which numbers of a normal matrix `(k, k)` have a part in a combination that it leaves undetermined `(k,)`."""
    d = np.sqrt(np.maximum(np.diag(A), 1e-300))
    values, vectors = np.linalg.eigh(A / d / d[:, None])
    return (np.abs(vectors[:, values < UNIDENTIFIED * values[-1]]) > WEIGHS).any(axis=1) | (np.diag(A) <= 0.0)


def memory(fitted: Fit) -> float:
    """How many readings say what one independent reading would: mean ratio of the sandwich to the inverse normal matrix
    over the directions that the readings determine, at least 1."""
    A, jacobians, residuals = scores(fitted)
    d = np.sqrt(np.maximum(np.diag(A), 1e-300))
    inverse = np.linalg.pinv(A / d / d[:, None], rcond=UNIDENTIFIED, hermitian=True)
    rank = max(int(np.linalg.matrix_rank(inverse, hermitian=True)), 1)
    return max(float(np.trace(inverse @ (meat(jacobians, residuals) / d / d[:, None]))) / rank, 1.0)


def uncertainty(fitted: Fit) -> Uncertainty:
    """Sandwich covariance of the free numbers (Huber 1967; White, Econometrica 50, 1982), and notes."""
    names = fitted.free
    scale = fitted.coordinates.slope(fitted.theta)
    A, jacobians, residuals = scores(fitted)
    known = np.diag(fitted.problem.precision[fitted.coordinates.index] * scale**2)
    A = A + known
    low, high = fitted.coordinates.on_bound(fitted.theta)
    values = fitted.numbers()
    notes = [
        f"{name} sits on its bound"
        for name, at in zip(names, low | high, strict=True)
        if at and values[name] != null_of_optional(name)
    ]
    diagonal = np.sqrt(np.maximum(np.diag(A), 0.0))
    silent = diagonal <= 1e-9 * max(np.max(diagonal, initial=0.0), 1e-300)
    notes += [
        f"{name} leaves no trace in these logs" for name, s in zip(names, silent & ~(low | high), strict=True) if s
    ]
    use = np.flatnonzero(~(low | high | silent))
    covariance, inflation = np.full((len(names), len(names)), np.inf), np.ones(len(names))
    if len(use):
        d = diagonal[use]
        strength, vectors = np.linalg.eigh(A[np.ix_(use, use)] / d / d[:, None])
        besides = np.einsum("ka,kl,la->a", vectors, known[np.ix_(use, use)] / d / d[:, None], vectors)
        weak = (strength < UNIDENTIFIED * strength[-1]) & (besides <= 0.5 * np.abs(strength))  # unless a prior says it
        for vector in vectors[:, weak].T:
            parts = [k for k in use[np.argsort(-np.abs(vector))] if abs(vector[list(use).index(k)]) > WEIGHS]
            notes.append(
                "only a combination of "
                + " and ".join(names[k] for k in parts)
                + " is determined by these logs: fix one"
            )
        spoilt = np.zeros(len(use), bool)
        for vector in vectors[:, weak].T:
            spoilt |= np.abs(vector) > WEIGHS
        inverse = (vectors[:, ~weak] / strength[~weak]) @ vectors[:, ~weak].T / d / d[:, None]
        middle = meat(jacobians, residuals) + fitted.problem.prior_weight * known
        sandwich = inverse @ middle[np.ix_(use, use)] @ inverse
        found = np.diag(sandwich) / np.diag(inverse)
        inflation[:] = np.mean(found[~spoilt]) if not spoilt.all() else np.mean(found)
        inflation[use[~spoilt]] = found[~spoilt]
        sandwich = sandwich * scale[use] * scale[use][:, None]
        sandwich[spoilt, :] = sandwich[:, spoilt] = np.inf
        covariance[np.ix_(use, use)] = sandwich
    return Uncertainty(names, covariance, inflation, tuple(notes))
