"""Standard errors that hold with correlated residuals, and what the logs leave undetermined, in words."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rwjax.effects.library import null_of_optional
from rwjax.fitting.gauss_newton import changes_of_numbers
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.sandwich import UNIDENTIFIED, WEIGHS, meat
from rwjax.fitting.sensitivities import residual_jacobian
from rwjax.simulation.batch import by_sample

TIED = 0.99
"""Correlation above which two numbers are hardly told apart [1]."""
SILENT = 1e-9
"""Size of a derivative, as a share of the largest one, below which a number leaves no trace [1]."""


@dataclass(frozen=True)
class Uncertainty:
    """How sure the free numbers of a fit are.

    Attributes:
        names: The free numbers.
        covariance: Their covariance `(k, k)` [SI²]; infinite for numbers on a bound or undetermined.
        inflation: Factor `(k,)` by which correlated residuals multiply the variance of each [1]; the mean of the others
            where a number has none.
        notes: What a user should know, one sentence each.
        silent: Those of the numbers a small change of which leaves no trace in the logs.
    """

    names: tuple[str, ...]
    covariance: np.ndarray
    inflation: np.ndarray
    notes: tuple[str, ...]
    silent: tuple[str, ...] = ()

    @property
    def tells_something(self) -> bool:
        """Whether any free number leaves a trace in the logs, if only together with others."""
        return len(self.silent) < len(self.names)

    def of(self, names: Sequence[str]) -> np.ndarray:
        """Covariance of some of the numbers.

        Args:
            names: Their names.

        Returns:
            Covariance `(names, names)` [SI²].
        """
        k = [self.names.index(name) for name in names]
        return self.covariance[np.ix_(k, k)]

    @property
    def standard_error(self) -> dict[str, float]:
        """Standard error of each free number [SI]."""
        return dict(zip(self.names, (float(v) for v in np.sqrt(np.diag(self.covariance))), strict=True))


def strongly_tied(found: Uncertainty) -> list[tuple[str, str, float]]:
    """Pairs of numbers that are hardly told apart.

    Args:
        found: The uncertainty of a fit.

    Returns:
        Pairs whose errors correlate by more than `TIED`, and by how much [1].
    """
    d = np.sqrt(np.diag(found.covariance))
    with np.errstate(invalid="ignore"):
        correlation = found.covariance / d / d[:, None]
    pairs = [(i, j) for i in range(len(d)) for j in range(i) if abs(correlation[i, j]) > TIED]
    return [(found.names[j], found.names[i], float(correlation[i, j])) for i, j in pairs]


class Scores(NamedTuple):
    """Derivatives of the readings' cost by the free coordinates, initial states eliminated; without the prior.

    Attributes:
        normal: Normal matrix `(k, k)` [1].
        jacobians: For each log the derivative of its residual `(time, output, k)` [1].
        residuals: For each log its residual in units of noise `(time, output)` [1].
    """

    normal: np.ndarray
    jacobians: list[np.ndarray]
    residuals: list[np.ndarray]


def scores(fitted: Fit) -> Scores:
    """Derivatives of a fit's residuals at its optimum.

    Args:
        fitted: The fit, with its derivatives.

    Returns:
        Normal matrix, and Jacobian and residual log by log.
    """
    problem, e, k = fitted.problem, fitted.evaluation, len(fitted.coordinates.index)
    scale = fitted.coordinates.slope(fitted.theta)
    A = np.zeros((k, k))
    jacobians, residuals = [], []
    for log, record in enumerate(problem.logs):
        along = changes_of_numbers(problem, e, log, k) * scale
        Gt = by_sample(problem.batch, log, residual_jacobian(e, log, along), len(record.time))
        flat = Gt.reshape(Gt.shape[0] * Gt.shape[1], k)
        A += flat.T @ flat
        jacobians.append(Gt)
        residuals.append(by_sample(problem.batch, log, e.residual[log], len(record.time)))
    return Scores(A, jacobians, residuals)


def readings_per_independent_one(fitted: Fit) -> float:
    """How many readings carry the information of one independent reading.

    It is the mean ratio of the sandwich to the inverse normal matrix, over the directions that the readings determine.

    Args:
        fitted: The fit, with its derivatives.

    Returns:
        The ratio, at least 1 [1].
    """
    A, jacobians, residuals = scores(fitted)
    d = np.sqrt(np.maximum(np.diag(A), 1e-300))
    inverse = np.linalg.pinv(A / d / d[:, None], rcond=UNIDENTIFIED, hermitian=True)
    rank = max(int(np.linalg.matrix_rank(inverse, hermitian=True)), 1)
    return max(float(np.trace(inverse @ (meat(jacobians, residuals) / d / d[:, None]))) / rank, 1.0)


def uncertainty(fitted: Fit) -> Uncertainty:
    """Sandwich covariance of the free numbers, and notes.

    Args:
        fitted: The fit, with its derivatives.

    Returns:
        The uncertainty.

    Source:
        Huber (1967); White, Econometrica 50 (1982).
    """
    names = fitted.free
    scale = fitted.coordinates.slope(fitted.theta)
    found = scores(fitted)
    known = np.diag(fitted.problem.precision[fitted.coordinates.index] * scale**2)
    A = found.normal + known
    on_bound = np.logical_or(*fitted.coordinates.on_bound(fitted.theta))
    values = fitted.numbers()
    notes = [
        f"{name} sits on its bound"
        for name, at in zip(names, on_bound, strict=True)
        if at and values[name] != null_of_optional(name)
    ]
    diagonal = np.sqrt(np.maximum(np.diag(A), 0.0))
    silent = diagonal <= SILENT * max(np.max(diagonal, initial=0.0), 1e-300)
    notes += [
        f"a small change of {name} leaves no trace in these logs"
        for name, s in zip(names, silent & ~on_bound, strict=True)
        if s
    ]
    use = np.flatnonzero(~(on_bound | silent))
    covariance, inflation = np.full((len(names), len(names)), np.inf), np.ones(len(names))
    if len(use):
        part = np.ix_(use, use)
        middle = meat(found.jacobians, found.residuals) + fitted.problem.prior_weight * known
        one = _sandwich(A[part], known[part], middle[part])
        for parts in one.combinations:
            together = " and ".join(names[use[k]] for k in parts)
            notes.append(f"only a combination of {together} is determined by these logs: fix one")
        inflation[:] = np.mean(one.inflation[~one.spoilt]) if not one.spoilt.all() else np.mean(one.inflation)
        inflation[use[~one.spoilt]] = one.inflation[~one.spoilt]
        scaled = one.covariance * scale[use] * scale[use][:, None]
        scaled[one.spoilt, :] = scaled[:, one.spoilt] = np.inf
        covariance[part] = scaled
    without_trace = tuple(name for name, s in zip(names, silent, strict=True) if s)
    return Uncertainty(names, covariance, inflation, tuple(notes), without_trace)


class _Sandwich(NamedTuple):
    """Covariance `(k, k)` of the coordinates and its inflation `(k,)`.

    `spoilt`: coordinates with a share in an undetermined combination `(k,)`; `combinations`: each one's members, those
    with the largest share first.
    """

    covariance: np.ndarray
    inflation: np.ndarray
    spoilt: np.ndarray
    combinations: list[list[int]]


def _sandwich(A: np.ndarray, known: np.ndarray, middle: np.ndarray) -> _Sandwich:
    """Sandwich of normal equations `A`, of which the prior is the part `known`, around the score's covariance `middle`."""
    d = np.sqrt(np.maximum(np.diag(A), 0.0))
    strength, vectors = np.linalg.eigh(A / d / d[:, None])
    besides = np.einsum("ka,kl,la->a", vectors, known / d / d[:, None], vectors)
    weak = (strength < UNIDENTIFIED * strength[-1]) & (besides <= 0.5 * np.abs(strength))  # unless a prior says it
    combinations = [
        [int(k) for k in np.argsort(-np.abs(vector)) if abs(vector[k]) > WEIGHS] for vector in vectors[:, weak].T
    ]
    spoilt = np.zeros(len(A), bool)
    for vector in vectors[:, weak].T:
        spoilt |= np.abs(vector) > WEIGHS
    inverse = (vectors[:, ~weak] / strength[~weak]) @ vectors[:, ~weak].T / d / d[:, None]
    covariance = inverse @ middle @ inverse
    return _Sandwich(covariance, np.diag(covariance) / np.diag(inverse), spoilt, combinations)
