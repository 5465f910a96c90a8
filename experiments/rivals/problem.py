"""One case as a regression: rows of the runs, columns of the base and of every effect's best form."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.rivals.dictionary import Form, Term, forms
from experiments.rivals.equations import Motion

ALONE = 1e-2
"""Share of a column's norm that the base has to leave, or the logs do not show the column."""
SAME = 0.999
"""Correlation from which two forms are the same."""


@dataclass(frozen=True)
class Problem:
    """A linear regression with groups.

    Attributes:
        y: What is left (n,), each equation in units of its own size [1].
        base: Changes with the free numbers (n, p), which every model holds.
        X: Columns of the effects (n, q).
        effects: Numbers of an effect's columns, by name; the first are its own, the rest may be shared.
        run: Number of the run of each row (n,).
        held_out: Whether a row is of a held-out run (n,).
    """

    y: np.ndarray
    base: np.ndarray
    X: np.ndarray
    effects: dict[str, tuple[int, ...]]
    run: np.ndarray
    held_out: np.ndarray

    def training(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Columns without what the base explains, of unit RMS, what is left likewise, and the run of each row."""
        told = ~self.held_out
        X, y = without(self.base[told], np.column_stack([self.X[told], self.y[told]])), np.zeros(0)
        X, y = X[:, :-1], X[:, -1]
        return X / (rms(X) + 1e-300), y / (float(rms(y[:, None])[0]) + 1e-300), self.run[told]

    def columns(self, names: Collection[str]) -> list[int]:
        """Numbers of the columns of some effects."""
        return sorted({k for name in names for k in self.effects[name]})

    def removed(self, names: Collection[str]) -> float:
        """Share of the held-out rows' squared error, as the base leaves it, that effects remove when fitted to the others [1]."""
        before = self._error(self.base)
        return 1.0 - self._error(np.column_stack([self.base, self.X[:, self.columns(names)]])) / before

    def _error(self, A: np.ndarray) -> float:
        told = ~self.held_out
        size = rms(A[told]) + 1e-300
        best = np.linalg.lstsq(A[told] / size, self.y[told], rcond=1e-8)[0]
        return float(np.sum((self.y - A / size @ best)[self.held_out] ** 2)) + 1e-300


def rms(X: np.ndarray) -> np.ndarray:
    """RMS of each column."""
    return np.sqrt(np.mean(X**2, axis=0))


def without(base: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Columns less their least-squares fit by a base."""
    if not base.size:
        return X
    U, s, _ = np.linalg.svd(base / (rms(base) + 1e-300), full_matrices=False)
    U = U[:, s > 1e-8 * s[0]]
    return X - U @ (U.T @ X)


def _stacked(runs: Sequence[Motion], equations: Sequence[str], of: Term) -> np.ndarray:
    """A term in all rows."""
    found = []
    for m in runs:
        blocks = of.of(m)
        found += [m.rows(e, blocks.get(e, np.zeros_like(m.t))) for e in equations]
    return np.concatenate(found)


def pose(runs: Sequence[Motion], held_out: Sequence[bool], free: Collection[str], among: Collection[str]) -> Problem:
    """The regression of a case.

    Args:
        runs: The runs.
        held_out: Which of them are held out.
        free: Names of the rig's free numbers.
        among: Names that may be given.

    Returns:
        The regression: of each effect the form that alone explains most of the training rows, without forms that the rows do not show and
        without effects that are the same as one before.
    """
    equations = [e for e in ("w", "Omega", "i") if all(e in m.model for m in runs)]
    parts = [(k, e, len(m.rows(e, m.t))) for k, m in enumerate(runs) for e in equations]
    run = np.concatenate([np.full(n, k) for k, _, n in parts])
    equation = np.concatenate([np.full(n, equations.index(e)) for _, e, n in parts])
    told = ~np.asarray(held_out)[run]
    y = np.concatenate([m.left(e) for m in runs for e in equations])
    base = np.column_stack([_stacked(runs, equations, Term(n, lambda m, n=n: m.by_number[n])) for n in free])
    first = without(base[told], y[told])
    size = np.array([rms(first[equation[told] == e][:, None])[0] for e in range(len(equations))])  # of each equation
    weight = 1.0 / np.maximum(size, 1e-300)[equation]
    y, base = weight * y, weight[:, None] * base
    left = without(base[told], y[told])
    columns: dict[str, np.ndarray] = {}
    effects: dict[str, tuple[int, ...]] = {}
    spans: list[np.ndarray] = []

    def column(term: Term) -> np.ndarray:
        if term.name not in columns:
            columns[term.name] = weight * _stacked(runs, equations, term)
        return columns[term.name]

    def seen(form: Form) -> np.ndarray:
        """An orthonormal basis of what a form's columns have beyond the base; empty where its own column has nothing."""
        X = np.column_stack([column(term) for term in form])[told]
        beyond = without(base[told], X)
        kept = np.linalg.norm(beyond, axis=0) > ALONE * np.linalg.norm(X, axis=0) + 1e-12
        if not kept[0]:
            return np.zeros((len(left), 0))
        return np.linalg.qr(beyond[:, kept] / rms(beyond[:, kept]))[0]

    kept: list[str] = []
    for name, choice in forms(list(runs)).items():
        if name not in among:
            continue
        span, form = max(((seen(f), f) for f in choice), key=lambda one: float(np.sum((one[0].T @ left) ** 2)))
        if not span.shape[1] or any(
            s.shape == span.shape and np.min(np.linalg.svd(s.T @ span, compute_uv=False)) > SAME for s in spans
        ):
            continue
        spans.append(span)
        beyond = [t.name for t in form if np.linalg.norm(without(base[told], column(t)[told])) > ALONE * np.linalg.norm(column(t)[told])]
        kept += [t for t in beyond if t not in kept]
        effects[name] = tuple(kept.index(t) for t in beyond)
    X = np.column_stack([columns[t] for t in kept]) if kept else np.zeros((len(y), 0))
    return Problem(y, base, X, effects, run, ~told)
