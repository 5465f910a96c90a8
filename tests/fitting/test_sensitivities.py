"""Derivatives log by log and of all logs at once."""

import numpy as np
import pytest

from rwjax.fitting.sensitivities import residual_jacobian, sensitivities
from rwjax.plant.from_rig import theta_of
from rwjax.simulation.free_run import free_run
from rwjax.simulation.shooting import evaluate
from tests.fitting.moving_runs import several
from tests.systems import platform


def test_sensitivities_log_by_log_are_those_of_all_at_once_and_none_where_no_reading_counts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rwjax.fitting.problem.LONG", 0)
    problem = several(platform("viscous = 0.02")).only((0, 2))
    theta = theta_of(platform("viscous = 0.02"), problem.structure)
    numbers = np.array([problem.structure.names.index(name) for name in ("axis.inertia", "axis.friction.viscous")])
    _, nodes = (np.asarray(a) for a in free_run(problem.structure, theta, problem.start, problem.batch))
    at_once = evaluate(problem.structure, theta, numbers, nodes, problem.batch)
    found = sensitivities(problem, theta, numbers, nodes)
    for name, one, all_of_them in zip(found._fields, found, at_once, strict=True):
        one, whole = (np.moveaxis(np.asarray(a), 1 if name == "local" else 0, 0) for a in (one, all_of_them))
        assert not one[1].any()
        assert np.max(np.abs(one[[0, 2]] - whole[[0, 2]])) <= 1e-12 * np.max(np.abs(whole)), name


def test_a_derivative_along_changes_is_that_of_each_number_and_state_combined() -> None:
    problem = several(platform("viscous = 0.02"))
    theta = theta_of(platform("viscous = 0.02"), problem.structure)
    _, nodes = (np.asarray(a) for a in free_run(problem.structure, theta, problem.start, problem.batch))
    e = sensitivities(problem, theta, np.array([0, 1]), nodes)
    each = residual_jacobian(e, 1)
    by_hand = np.einsum("nwqy,wnc->wqyc", e.local[-2:, 1], e.chain[1])
    by_hand[..., : len(e.local) - 2] += np.moveaxis(e.local[:-2, 1], 0, -1)
    assert each == pytest.approx(by_hand, rel=1e-12, abs=1e-12 * np.abs(by_hand).max())
    along = np.random.default_rng(0).normal(size=(len(e.local), 3))
    found = residual_jacobian(e, 1, along, windows=2)
    assert found == pytest.approx(each[:2] @ along, rel=1e-9, abs=1e-12 * np.abs(by_hand).max())
