"""Three ways to choose names by regression, each from a kept library or textbook.

* STLSQ of PySINDy: Brunton, Proctor, Kutz, PNAS 113 (2016); de Silva et al., J. Open Source Softw. 5 (2020).
* Lasso of scikit-learn: Tibshirani, J. R. Stat. Soc. B 58 (1996), its weight by the rule of one standard error.
* Forward selection by BIC: Schwarz, Ann. Stat. 6 (1978), with as many rows as are independent.

Thresholds of the first and weights of the second are chosen by leaving out one training run after another.
"""

import warnings
from collections.abc import Callable, Iterable

import numpy as np

from experiments.rivals.problem import Problem

THRESHOLDS = np.geomspace(0.03, 1.0, 12)
"""Thresholds of STLSQ on coefficients of columns of unit RMS, in units of the RMS of what is left [1]."""
WEIGHTS = np.geomspace(0.01, 1.0, 16)
"""Weights of the lasso, in units of the least one that leaves no coefficient [1]."""
RIDGE = 0.01
"""Ridge of STLSQ, for columns of unit RMS [1]."""
LEAST = 0.15
"""Share of what all chosen names together explain that a name has to add to the others, or it is dropped [1]."""
MOST = 4
"""Names that forward selection gives at most."""
INCLUDES = {
    "axis.stribeck": "axis.coulomb",
    "axis.presliding": "axis.coulomb",
    "axis.spring": "axis.bias_torque",
}
"""Names that belong to another name: sliding friction to the laws that have a level, a constant torque to a spring's angle of rest."""


def stlsq(problem: Problem) -> list[str]:
    """Names by sequentially thresholded least squares.

    Args:
        problem: The regression.

    Returns:
        The names, the one that adds most first.
    """
    return _by_coefficients(problem, _by_stlsq, lambda X, y: THRESHOLDS)


def lasso(problem: Problem) -> list[str]:
    """Names by the lasso.

    Args:
        problem: The regression.

    Returns:
        The names, the one that adds most first.
    """
    return _by_coefficients(problem, _by_lasso, lambda X, y: WEIGHTS * float(np.max(np.abs(X.T @ y))) / len(y))


Coefficients = Callable[[float, np.ndarray, np.ndarray], np.ndarray]
"""Coefficients (k,) at a level, for columns (n, k) and what they have to explain (n,)."""


def _by_stlsq(threshold: float, X: np.ndarray, y: np.ndarray) -> np.ndarray:
    from pysindy import STLSQ

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a threshold above every coefficient is an answer: nothing
        return np.ravel(STLSQ(threshold=threshold, alpha=RIDGE * len(y), max_iter=20).fit(X, y[:, None]).coef_)


def _by_lasso(weight: float, X: np.ndarray, y: np.ndarray) -> np.ndarray:
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.linear_model import Lasso

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # of the smallest weights, which leave all columns in
        return Lasso(alpha=weight, fit_intercept=False, max_iter=2000, tol=1e-3).fit(X, y).coef_


def _by_coefficients(
    problem: Problem, fit: Coefficients, levels: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> list[str]:
    """Names of the columns that have a coefficient at the level that leaving out one run after another chooses."""
    X, y, run = problem.training()
    return _pruned(problem, np.flatnonzero(_sparsest(fit, levels(X, y), X, y, run))) if problem.effects else []


def forward(problem: Problem) -> list[str]:
    """Names by forward selection with the Bayesian information criterion.

    Args:
        problem: The regression.

    Returns:
        The names, the one that adds most first.
    """
    X, y, run = problem.training()
    chosen: list[str] = []
    while len(chosen) < min(MOST, len(problem.effects)):
        rest = _left(X[:, problem.columns(chosen)], y)
        n = independent(rest, run)
        level = n * np.log(np.sum(rest**2)) + np.log(n) * len(problem.columns(chosen))
        tried = {}
        for name in problem.effects:
            if name not in chosen:
                columns = problem.columns([*chosen, name])
                tried[name] = n * np.log(np.sum(_left(X[:, columns], y) ** 2)) + np.log(n) * len(columns)
        best = min(tried, key=lambda name: tried[name], default=None)
        if best is None or tried[best] >= level:
            break
        chosen.append(best)
    return _ordered(problem, chosen)


def independent(rest: np.ndarray, run: np.ndarray) -> float:
    """Number of independent rows among correlated ones: n / (1 + 2 Σρ), lags up to the first negative correlation.

    Args:
        rest: Residuals of the rows (n,) [1].
        run: Number of the run of each row (n,).

    Returns:
        The number [1].
    """
    of = [rest[run == k] for k in np.unique(run)]
    square, total = float(np.sum(rest**2)), 0.0
    for lag in range(1, min(len(r) for r in of)):
        rho = sum(float(r[lag:] @ r[:-lag]) for r in of) / square
        if rho <= 0.0:
            break
        total += rho
    return len(rest) / (1.0 + 2.0 * total)


def _left(X: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What least squares leave."""
    return y - X @ np.linalg.lstsq(X, y, rcond=1e-8)[0] if X.shape[1] else y


def _sparsest(
    fit: Coefficients,
    levels: Iterable[float],
    X: np.ndarray,
    y: np.ndarray,
    run: np.ndarray,
) -> np.ndarray:
    """Coefficients at the highest level whose error on runs left out lies within a standard error of the lowest one."""
    levels, runs = list(levels), np.unique(run)
    error = np.empty((len(levels), len(runs)))
    for j, k in enumerate(runs):
        out = run == k
        for a, level in enumerate(levels):
            error[a, j] = np.mean((y[out] - X[out] @ fit(level, X[~out], y[~out])) ** 2) if len(runs) > 1 else 1.0
    mean = error.mean(axis=1)
    best = int(np.argmin(mean))
    spread = (error - error[best]).std(axis=1, ddof=min(1, len(runs) - 1)) / np.sqrt(len(runs))
    good = [a for a in range(len(levels)) if mean[a] <= mean[best] + spread[a]]
    return fit(levels[max(good)], X, y)


def _pruned(problem: Problem, columns: np.ndarray) -> list[str]:
    """Names of columns: an effect is named for a column that it does not share with one before it."""
    owner: dict[int, str] = {}
    for name in sorted(problem.effects, key=lambda name: len(problem.effects[name])):
        for k in problem.effects[name]:
            owner.setdefault(k, name)
    return _ordered(problem, list(dict.fromkeys(owner[int(k)] for k in columns)))


def _ordered(problem: Problem, names: list[str]) -> list[str]:
    """Names by what each adds to the others, without those that belong to another one or add little."""
    names = [n for n in names if not any(INCLUDES.get(other) == n for other in names)]
    X, y, _ = problem.training()

    def error(some: list[str]) -> float:
        return float(np.sum(_left(X[:, problem.columns(some)], y) ** 2))

    while names:
        every, nothing = error(names), error([])
        adds = {n: error([m for m in names if m != n]) - every for n in names}
        least = min(names, key=lambda n: adds[n])
        if len(names) == 1 or adds[least] >= LEAST * (nothing - every):
            return sorted(names, key=lambda n: -adds[n])
        names = [n for n in names if n != least]
    return []
