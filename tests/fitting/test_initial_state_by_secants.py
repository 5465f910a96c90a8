"""Initial states by secants against those by exact sensitivities."""

import numpy as np
import pytest

from rwjax.fitting.batched_runs import together
from rwjax.fitting.initial_state import initial_states_by_sensitivities
from rwjax.fitting.initial_state_by_secants import initial_states_by_secants
from rwjax.plant.from_rig import theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from tests.fitting.moving_runs import several
from tests.systems import platform, reaction


@pytest.mark.parametrize("rig", [platform(), platform("viscous = 0.02"), reaction()], ids=["dry", "smooth", "reaction"])
def test_first_states_agree_with_those_by_exact_sensitivities(rig: Rig) -> None:
    problem = several(rig)
    theta = theta_of(rig, problem.structure)
    exact, found = (
        initial_states_by_sensitivities(problem, theta),
        together([initial_states_by_secants(problem, theta)])[0],
    )

    def early(start: np.ndarray) -> np.ndarray:
        y, _ = free_run(problem.structure, theta, start, problem.start_only.batch)
        square = ((np.asarray(y) - problem.start_only.batch.reading) * problem.start_only.batch.weight) ** 2
        return np.sum(square, axis=(1, 2, 3))

    assert np.all(early(found) <= early(exact) * (1.0 + 1e-5))
    seen = [problem.structure.states.index(name) for name in ("psi", "w")]
    assert np.max(np.abs(found - exact)[:, seen]) < 2e-3  # a few per cent of what noise does to a start
