"""The interface of a solver: what one gets without defining it, through a solver of a user's own."""

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from rwjax.logs.log import Log
from rwjax.plant.plant import Plant
from rwjax.rig.model import Rig
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT
from rwjax.simulation.simulate import simulate
from rwjax.simulation.solver import Solver, ThroughWindow
from tests.systems import platform

T = np.arange(11) * 0.02


class Halved(Solver):
    """Half of what the exact solver reads: all that the interface asks for, and no more."""

    name = "halved"
    share: float = 0.5

    @property
    def from_library(self) -> bool:
        return False

    def suited(self, rig: Rig, logs: Sequence[Log]) -> "Halved":
        return self

    def through_windows(self, plant: Plant, run: Batch) -> tuple[ThroughWindow, Any]:
        window, inputs = EXACT.through_windows(plant, run)

        def halved(x: Array, given: Any) -> tuple[Array, Array]:
            end, y = window(x, given)
            return end, self.share * y

        return halved, inputs


def test_a_solver_of_ones_own_simulates() -> None:
    found, exact = (simulate(platform(), T, np.full_like(T, 0.5), solver=s) for s in (Halved(), EXACT))
    for y in exact:
        assert found[y] == pytest.approx(0.5 * exact[y])


def test_what_a_solver_does_not_define_is_that_of_an_exact_one() -> None:
    solver = Halved()
    assert not solver.smooth and solver.sign_width is None and solver.by_commands() is solver
    assert solver.notes(platform(), []) == []
    z = jnp.arange(3.0)
    np.testing.assert_array_equal(solver.of_vector(lambda own, z: own.share * z, z), 0.5 * z)


def test_the_interface_alone_is_no_solver() -> None:
    with pytest.raises(TypeError, match="abstract"):
        Solver()  # type: ignore[abstract]
