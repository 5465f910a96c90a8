"""Secants against exact sensitivities, and fits by them."""

import numpy as np
import pytest

from rwjax.fitting.batched_runs import together
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.problem import pose
from rwjax.fitting.secant import descend, search_point, slopes, with_residual
from rwjax.fitting.sensitivities import residual_jacobian, sensitivities
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.simulation.free_run import free_run
from tests.fitting.moving_runs import STEP_OF_COMMAND, alone, moving, several, starting_with_a_jump, with_jump
from tests.systems import platform


def test_slopes_are_the_sensitivities_of_a_smooth_plant() -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    problem = several(rig)
    theta = theta_of(rig, problem.structure)
    free = np.array([name in rig.free for name in problem.structure.names])
    c = coordinates(theta, free, bounds_of(rig, problem.structure), np.maximum(np.abs(theta), 1e-3))
    residual = alone(problem, theta, problem.start)
    e = together([slopes(problem, c, theta, problem.start, residual, 1e-5)])[0]
    _, nodes = free_run(problem.structure, theta, problem.start, problem.batch)
    exact = sensitivities(problem, theta, c.index, np.asarray(nodes))
    for log in range(3):
        through = residual_jacobian(exact, log)
        columns = [0, 1, through.shape[-1] - 2, through.shape[-1] - 1]  # numbers, then states; zeros between
        for k, column in enumerate(columns):
            scale = np.max(np.abs(through[..., column]))
            assert np.max(np.abs(e.local[k, log] - through[..., column])) < 1e-4 * scale


@pytest.mark.parametrize("beyond", [np.inf, np.nan, 1e160])
def test_a_number_whose_run_leaves_the_range_of_numbers_is_not_moved(beyond: float) -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    problem = several(rig)
    theta = theta_of(rig, problem.structure)
    free = np.array([name in rig.free for name in problem.structure.names])
    c = coordinates(theta, free, bounds_of(rig, problem.structure), np.maximum(np.abs(theta), 1e-3))
    search = slopes(problem, c, theta, problem.start, np.zeros_like(problem.batch.reading), 1e-2)
    wanted = next(search)
    y = np.stack([problem.batch.reading[wanted.logs, : wanted.windows] + 0.1] * len(wanted.theta))
    y[0] = beyond
    with pytest.raises(StopIteration) as end:
        search.send(y)
    e = end.value.value
    assert not e.local[0].any() and e.local[1].any()
    assert np.all(np.isfinite(e.H)) and not e.H[:, 0].any() and np.all(e.H[:, 1, 1] > 0.0)


def test_a_descent_by_secants_finds_the_numbers_of_runs_without_noise() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05", free='"axis.inertia", "axis.friction.coulomb"')
    logs = [moving(rig, noise=0.0), moving(rig, {"w": -0.7}, noise=0.0)]
    problem = pose(structure_of(rig), logs, {"yaw_rad": 1e-3})
    truth = theta_of(rig, problem.structure)
    free = np.array([name in rig.free for name in problem.structure.names])
    c = coordinates(truth, free, bounds_of(rig, problem.structure), np.maximum(np.abs(truth), 1e-3))
    for p in (problem, problem.from_start):
        here = together([with_residual(search_point(p, c, np.where(free, 1.3 * truth, truth), p.start))])[0]
        found = together([descend(here, most_steps=25, tolerance=1e-9)])[0]
        assert found.theta[c.index] == pytest.approx(truth[c.index], rel=1e-4)
        assert found.cost < 1e-3 * here.cost


@pytest.mark.parametrize("begun", [0.2, 0.3125])
def test_a_descent_finds_a_threshold_between_two_commands_where_a_small_change_of_it_changes_nothing(
    begun: float,
) -> None:
    problem = starting_with_a_jump(0.25)
    theta, c = with_jump(problem, begun)
    here = together([with_residual(search_point(problem, c, theta, problem.start))])[0]
    found = together([descend(here, most_steps=25, tolerance=1e-9)])[0]
    assert here.cost > 1e3 and found.cost < 1e-3
    assert abs(found.theta[c.index[0]] - 0.25) < STEP_OF_COMMAND
