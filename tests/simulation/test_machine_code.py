"""Lowered programs of the simulation against the same programs through XLA: every kind, effect, command and servo."""

from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np
import pytest

from rwjax.lowering.kept import THROUGH_XLA
from rwjax.plant.plant import Plant
from rwjax.plant.structure import Structure
from rwjax.simulation import machine_code
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT, Exact
from rwjax.simulation.exponential_step import SQUARINGS, ExponentialStep, Matrix, Propagator
from rwjax.simulation.free_run import free_run, free_runs
from rwjax.simulation.shooting import Evaluation, evaluate
from rwjax.types import Scalar
from tests.simulation.plants import CASES, FAST

LAST_DIGITS = np.finfo(float).eps * 2.0**SQUARINGS
"""Relative error that rounding makes in the exponentials of a step: each of their squarings doubles it. All steps share it."""


def _close(
    found: np.ndarray, wanted: np.ndarray, within: float, size: float = 0.0, moved: np.ndarray | float = 0.0
) -> None:
    found, wanted = np.asarray(found), np.asarray(wanted)
    assert found.shape == wanted.shape
    assert np.isfinite(wanted).all()
    assert np.all(np.abs(found - wanted) <= within * max(np.max(np.abs(wanted), initial=0.0), size) + moved)


@dataclass(frozen=True)
class _OtherwiseRounded(ExponentialStep):
    """The same steps by exponentials that are off by what rounding may do to them."""

    from_library: ClassVar[bool] = False

    def prepare(self, plant: Plant, h: Scalar) -> Propagator:
        p, rng = super().prepare(plant, h), np.random.default_rng(0)

        def off(M: Matrix) -> Matrix:
            return tuple(tuple(entry * (1.0 + LAST_DIGITS * rng.choice([-1.0, 1.0])) for entry in row) for row in M)

        return p._replace(E=off(p.E), phi1=off(p.phi1), phi2=off(p.phi2))


def _moved(structure: Structure, theta: np.ndarray, start: np.ndarray, batch: Batch) -> tuple[np.ndarray, ...]:
    """By how much XLA's own run leaves itself, up to each window, where numbers, start and exponentials are rounded otherwise."""
    rng, wanted, moved = np.random.default_rng(0), free_run(structure, theta, start, batch), []
    solver = Exact(stepper=_OtherwiseRounded())
    for _ in range(4):
        a, b = (v * (1.0 + LAST_DIGITS * rng.choice([-1.0, 1.0], v.shape)) for v in (theta, start))
        other = free_run(structure, a, b, batch, solver=solver)
        moved.append([np.abs(there - here) for there, here in zip(other, wanted, strict=True)])
    most = [np.max(part, axis=0) for part in zip(*moved, strict=True)]
    so_far = [np.maximum.accumulate(part.max(axis=(0, *range(2, part.ndim)))) for part in most]
    return tuple(by.reshape(1, -1, *[1] * (part.ndim - 2)) for by, part in zip(so_far, most, strict=True))


def _kept(e: Evaluation, columns: np.ndarray) -> Evaluation:
    """An evaluation as arrays, of some columns of its derivatives, which come first."""
    e = Evaluation(*map(np.asarray, e))
    chain = np.moveaxis(e.chain, -1, 0)[columns]
    return e._replace(H=e.H[:, columns][:, :, columns], g=e.g[:, columns], local=e.local[columns], chain=chain)


def _same_evaluation(e: Evaluation, of_xla: Evaluation, rounded: Evaluation, size: float) -> None:
    """Equal up to rounding, and up to what exponentials that are rounded otherwise change."""
    e = e._replace(chain=np.moveaxis(np.asarray(e.chain), -1, 0))
    for field, within in (("residual", 1e-11), ("defect", 1e-11), ("shift", 1e-11), ("H", 1e-10), ("g", 1e-10)):
        wanted, other = getattr(of_xla, field), getattr(rounded, field)
        least = size if field in ("defect", "shift") else 0.0
        _close(getattr(e, field), wanted, within, least, 2.0 * np.max(np.abs(other - wanted)))
    for field in ("local", "chain"):
        for column, wanted, other in zip(*(getattr(each, field) for each in (e, of_xla, rounded)), strict=True):
            moved = 2.0 * np.max(np.abs(other - wanted), initial=0.0)
            _close(column, wanted, 1e-9, moved=moved)  # a column may be the difference of larger ones


@pytest.mark.parametrize(
    "name", [case if case in FAST else pytest.param(case, marks=pytest.mark.slow) for case in CASES]
)
def test_lowered_programs_are_those_of_xla(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    structure, theta, batch = CASES[name]()
    begin = {"w": 1.0, "Omega": 20.0, "w_1": 1.0, "w_2": 0.5, "Omega_1": 20.0, "Omega_2": 10.0}
    start = np.array([[begin.get(state, 0.0) for state in structure.states]])
    several = theta * (1.0 + 1e-3 * np.arange(3)[:, None]), np.repeat(start, 3, axis=0)
    assert machine_code.runs(structure, *several, 2, batch, EXACT) is not None
    y, nodes = free_run(structure, theta, start, batch)
    off = np.asarray(nodes) * (1.0 + 0.01 * np.cos(np.arange(batch.windows)))[:, None]  # windows that do not join
    numbers = np.arange(len(theta))
    assert machine_code.sensitivities(structure, theta, numbers, off[0], batch, 0, EXACT) is not None
    runs, e = free_runs(structure, *several, 2, batch), evaluate(structure, theta, numbers, off, batch)
    monkeypatch.setenv(THROUGH_XLA, "1")
    wanted = free_run(structure, theta, start, batch)
    steps = len(batch.step_index) * batch.windows
    moved = _moved(structure, theta, start, batch)
    _close(y, wanted[0], 1e-14 * steps, moved=2.0 * moved[0])  # rounding of every step, and what becomes of it
    _close(nodes, wanted[1], 1e-14 * steps, moved=2.0 * moved[1])
    _close(runs, free_runs(structure, *several, 2, batch), 1e-14 * steps)
    x, n = evaluate(structure, theta, numbers, off, batch), len(structure.states)
    kept = np.concatenate([numbers, np.arange(len(x.local) - n, len(x.local))])  # XLA's program adds columns of zeros
    rounded = evaluate(structure, theta, numbers, off, batch, solver=Exact(stepper=_OtherwiseRounded()))
    _same_evaluation(e, _kept(x, kept), _kept(rounded, kept), float(np.max(np.abs(off))))
    jax.clear_caches()


@pytest.mark.parametrize("n", [2, 20])
def test_columns_carried_from_window_to_window(n: int) -> None:
    """Few states and many: equal to powers of one matrix, $c_w = A^w c_0 + \\sum_{i<w} A^i b$."""
    rng = np.random.default_rng(0)
    A, b, first = rng.normal(size=(n, n)) / n, rng.normal(size=(3, n)), rng.normal(size=(3, n))
    found = machine_code.continued(np.broadcast_to(A, (5, n, n)), np.repeat(b[:, None], 5, axis=1), first)
    powers = [np.linalg.matrix_power(A, w) for w in range(5)]
    wanted = [powers[w] @ first.T + sum((powers[i] @ b.T for i in range(w)), np.zeros((n, 3))) for w in range(5)]
    assert found is not None
    assert found == pytest.approx(np.moveaxis(wanted, -1, 0), abs=1e-13)
