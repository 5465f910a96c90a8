"""Secant steps of a nonsmooth cost."""

import numpy as np
import pytest

from rwjax.fitting.multiple_shooting import least_squares
from rwjax.fitting.nonsmooth import beyond_stairs, leaves_no_trace, past_ridges, secant_steps, sticks
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of
from tests.fitting.heavier import believed_heavier
from tests.fitting.logs import log_of
from tests.fitting.moving_runs import STEP_OF_COMMAND, starting_with_a_jump, with_jump
from tests.systems import platform


def test_secant_steps_heed_a_prior() -> None:
    problem, moves, theta = believed_heavier()
    begun = least_squares(problem, moves, theta, most_steps=0)
    found = secant_steps(begun)
    again = least_squares(problem, moves, found.theta, start=found.start, most_steps=0)
    assert found.cost < 0.2 * begun.cost and found.cost == pytest.approx(again.cost, rel=1e-9)
    assert found.theta[problem.names.index("axis.inertia")] == pytest.approx(0.12, rel=0.05)


def test_friction_in_proportion_to_the_load_sticks_like_any_other() -> None:
    smooth = platform("viscous = 0.02")
    problem = pose(structure_of(smooth).with_effects("axis.load_friction"), [log_of(smooth)])
    theta = np.zeros(len(problem.names))
    assert not sticks(problem, theta)
    theta[problem.names.index("axis.load_friction.mu")] = 0.1
    assert sticks(problem, theta)


def test_a_fit_goes_on_where_a_threshold_lies_between_two_commands() -> None:
    problem = starting_with_a_jump(0.25)
    theta, moves = with_jump(problem, 0.2)
    found = least_squares(problem, moves, theta)
    assert leaves_no_trace(found) and found.cost > 1e3 and not sticks(problem, found.theta)
    assert past_ridges(found).cost < 1e-3
    smooth, moves, theta = believed_heavier()
    assert not leaves_no_trace(least_squares(smooth, moves, theta, most_steps=0))


@pytest.mark.parametrize(("jump", "begun"), [(0.1, 0.4), (0.4, 0.25), (0.0, 0.6)])
def test_a_number_without_trace_is_found_many_steps_of_its_stairs_away(jump: float, begun: float) -> None:
    problem = starting_with_a_jump(jump)
    theta, moves = with_jump(problem, begun)
    found = least_squares(problem, moves, theta)
    assert found.cost > 1e3 and leaves_no_trace(found)
    better = beyond_stairs(found)
    assert better.cost < 1e-3
    assert better.theta[moves.index[0]] == pytest.approx(jump, abs=STEP_OF_COMMAND)


def test_a_number_that_may_as_well_be_0_is_0() -> None:
    problem = starting_with_a_jump(0.0)
    theta, moves = with_jump(problem, 0.2 * STEP_OF_COMMAND)
    assert least_squares(problem, moves, theta).theta[moves.index[0]] > 0.0
    found = beyond_stairs(least_squares(problem, moves, theta))
    assert found.theta[moves.index[0]] == 0.0 and found.cost < 1e-3


def test_a_fit_whose_numbers_all_leave_a_trace_stays_what_it_is() -> None:
    smooth, moves, theta = believed_heavier()
    found = least_squares(smooth, moves, theta)
    assert beyond_stairs(found) is found
