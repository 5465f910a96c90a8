"""One case as a regression: rows of the runs, columns of the base and of every effect's best form."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.rivals.dictionary import Form, Term, forms
from experiments.rivals.equations import Motion

ALONE = 1e-2
"""Share of a column's norm that the base has to leave, or the logs do not show the column."""
FEWEST = 20
"""Training rows below which nothing is asked [1]."""
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
        both = without(self.base[told], np.column_stack([self.X[told], self.y[told]]))
        X, y = both[:, :-1], both[:, -1]
        return X / (rms(X) + 1e-300), y / (float(rms(y[:, None])[0]) + 1e-300), self.run[told]

    def columns(self, names: Collection[str]) -> list[int]:
        """Numbers of the columns of some effects."""
        return sorted({k for name in names for k in self.effects[name]})

    def removed(self, names: Collection[str]) -> float:
        """Share of the held-out rows' squared error, as the base leaves it, that effects remove when fitted to the others [1]."""
        if not names:
            return 0.0
        before = self._error(self.base)
        return 1.0 - self._error(np.column_stack([self.base, self.X[:, self.columns(names)]])) / before

    def _error(self, A: np.ndarray) -> float:
        told = ~self.held_out
        size = rms(A[told]) + 1e-300
        best = np.linalg.lstsq(A[told] / size, self.y[told], rcond=1e-8)[0]
        return float(np.sum((self.y - A / size @ best)[self.held_out] ** 2)) + 1e-300


def rms(X: np.ndarray) -> np.ndarray:
    """RMS of each column."""
    return np.sqrt(np.sum(X**2, axis=0) / max(len(X), 1))


def without(base: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Columns less their least-squares fit by a base."""
    if not base.size:
        return X
    U, s, _ = np.linalg.svd(base / (rms(base) + 1e-300), full_matrices=False)
    U = U[:, s > 1e-8 * s[0]]
    return X - U @ (U.T @ X)


class _Rows:
    """The rows of a case while its columns are chosen."""

    def __init__(self, runs: Sequence[Motion], held_out: Sequence[bool], free: Collection[str]) -> None:
        self.runs = list(runs)
        self.equations = [e for e in ("w", "Omega", "i") if all(e in m.model for m in runs)]
        parts = [(k, j, len(m.rows(e, m.t))) for k, m in enumerate(runs) for j, e in enumerate(self.equations)]
        self.run = np.concatenate([np.full(n, k) for k, _, n in parts])
        equation = np.concatenate([np.full(n, j) for _, j, n in parts])
        self.told = ~np.asarray(held_out)[self.run]
        y = np.concatenate([m.left(e) for m in runs for e in self.equations])
        base = np.column_stack([self._stacked(Term(n, lambda m, n=n: m.by_number[n])) for n in free])
        first = without(base[self.told], y[self.told])
        of = equation[self.told]
        size = np.array([float(rms(first[of == j][:, None])[0]) for j in range(len(self.equations))])
        self.weight = 1.0 / np.maximum(size, 1e-300)[equation]
        self.y, self.base = self.weight * y, self.weight[:, None] * base
        self.left = without(self.base[self.told], self.y[self.told])
        self.columns: dict[str, np.ndarray] = {}

    def _stacked(self, term: Term) -> np.ndarray:
        """A term in all rows."""
        found = []
        for m in self.runs:
            blocks = term.of(m)
            found += [m.rows(e, blocks.get(e, np.zeros_like(m.t))) for e in self.equations]
        return np.concatenate(found)

    def column(self, term: Term) -> np.ndarray:
        """A term in all rows, in the units of the rows."""
        if term.name not in self.columns:
            self.columns[term.name] = self.weight * self._stacked(term)
        return self.columns[term.name]

    def seen(self, form: Form) -> tuple[np.ndarray, list[str]]:
        """What the training rows show of a form beyond the base: an orthonormal basis, and the terms; nothing without its own term."""
        X = np.column_stack([self.column(term) for term in form])[self.told]
        beyond = without(self.base[self.told], X)
        kept = np.linalg.norm(beyond, axis=0) > ALONE * np.linalg.norm(X, axis=0) + 1e-12
        if not kept[0]:
            return np.zeros((len(X), 0)), []
        basis = np.linalg.qr(beyond[:, kept] / rms(beyond[:, kept]))[0]
        return basis, [term.name for term, k in zip(form, kept, strict=True) if k]

    def explained(self, basis: np.ndarray) -> float:
        """Squared size of what a basis explains of what is left."""
        return float(np.sum((basis.T @ self.left) ** 2))


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two orthonormal bases span the same."""
    return a.shape == b.shape and float(np.min(np.linalg.svd(a.T @ b, compute_uv=False))) > SAME


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
    rows = _Rows(runs, held_out, free)
    effects: dict[str, tuple[int, ...]] = {}
    bases: list[np.ndarray] = []
    kept: list[str] = []
    for name, choice in forms(rows.runs).items() if rows.told.sum() >= FEWEST else ():
        if name not in among:
            continue
        basis, terms = max(map(rows.seen, choice), key=lambda one: rows.explained(one[0]))
        if not terms or any(_same(basis, other) for other in bases):
            continue
        bases.append(basis)
        kept += [term for term in terms if term not in kept]
        effects[name] = tuple(kept.index(term) for term in terms)
    X = np.column_stack([rows.columns[term] for term in kept]) if kept else np.zeros((len(rows.y), 0))
    return Problem(rows.y, rows.base, X, effects, rows.run, ~rows.told)
