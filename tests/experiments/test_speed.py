"""The benchmark's rivals solve the library's own problem: written independently, they agree with it to rounding."""

from collections.abc import Callable

import numpy as np
import pytest

pytest.importorskip("numba", reason="the benchmark's rivals need the extra `experiments`")

from experiments.speed import c_limit, scipy_numba
from experiments.speed.problem import BELIEVED, FIRST_STATE, FREE, TRUE, Arrays, arrays, log, posed, rig
from rwjax.fitting.fit import fit
from rwjax.simulation.batch import by_sample
from rwjax.simulation.free_run import free_run

SECONDS = 12.0
NEEDS_GCC = pytest.mark.skipif(not c_limit.available(), reason="the C program needs gcc")


@pytest.fixture(scope="module")
def given() -> Arrays:
    return arrays(log(SECONDS))


def _residual(numbers: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The library's own, sample by sample."""
    problem, moves, theta = posed(log(SECONDS))
    theta[moves.index] = numbers
    y, _ = free_run(problem.structure, theta, first[None], problem.batch)
    batch = problem.batch
    misfit = (np.asarray(y)[0] - batch.reading[0]) * batch.weight[0]
    return by_sample(batch, 0, misfit, len(log(SECONDS).time))[:, 0]


@pytest.mark.parametrize(
    "other", [scipy_numba.residual, pytest.param(c_limit.residual, marks=NEEDS_GCC)], ids=["numba", "C"]
)
@pytest.mark.parametrize("numbers", [TRUE, BELIEVED])
def test_the_rivals_simulate_the_same_plant(given: Arrays, other: Callable, numbers: np.ndarray) -> None:
    first = np.array(FIRST_STATE)
    difference = other(given, numbers, first) - _residual(numbers, first)
    assert np.max(np.abs(difference / given.weight)) < 1e-10  # rad


@NEEDS_GCC
def test_c_and_numba_end_at_the_optimum_of_the_library(given: Arrays) -> None:
    ours = fit(rig(), [log(SECONDS)])
    for found in (c_limit.Fitter(given).fit(BELIEVED), scipy_numba.fit(given)):
        assert found.cost == pytest.approx(ours.fit.cost, rel=1e-6)
        assert found.numbers == pytest.approx([ours.rig.values[name] for name in FREE], rel=1e-5)
        assert found.first == pytest.approx(ours.fit.start[0], abs=1e-5)
