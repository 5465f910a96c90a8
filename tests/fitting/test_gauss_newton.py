"""Gauss-Newton steps with a prior, at a bound, and where nothing is known."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.gauss_newton import gauss_newton_step, initial_state_response, steps_without
from rwjax.fitting.multiple_shooting import least_squares
from tests.fitting.heavier import believed_heavier


def test_a_step_goes_all_the_way_to_a_sure_prior() -> None:
    problem, moves, theta = believed_heavier()
    begun = least_squares(problem, moves, theta, most_steps=0)
    once = least_squares(problem, moves, theta, damping=0.0, most_steps=1)
    assert begun.theta[moves.index[0]] == 0.1
    assert once.theta[problem.names.index("axis.inertia")] == pytest.approx(0.1 * np.exp(0.2), rel=1e-3)


def linear(H: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Response of the last two unknowns to the first."""
    return initial_state_response(H, g, np.array([0]), np.array([1, 2]), 0.0)


def test_initial_states_respond_as_the_minimum_of_a_parabola_does() -> None:
    rng = np.random.default_rng(0)
    J, r = rng.normal(size=(40, 3)), rng.normal(size=40)
    P, q = linear(J.T @ J, J.T @ r)
    for z in (0.0, 0.7):
        direct = np.linalg.lstsq(J[:, 1:], -(r + J[:, 0] * z), rcond=None)[0]
        assert P[:, 0] * z + q == pytest.approx(direct, rel=1e-6, abs=1e-9)


def test_initial_states_that_no_reading_depends_on_stay() -> None:
    P, q = linear(np.diag([1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))
    assert not P.any() and not q.any()


@pytest.mark.parametrize("size", [np.nan, np.inf])
def test_initial_states_do_not_respond_to_readings_beyond_all_numbers(size: float) -> None:
    P, q = linear(np.full((3, 3), size), np.ones(3))
    assert np.isnan(P).all() and np.isnan(q).all()


def test_derivatives_that_are_not_finite_give_no_step() -> None:
    problem, moves, theta = believed_heavier()
    e = least_squares(problem, moves, theta, most_steps=0).evaluation
    assert gauss_newton_step(problem, e, moves, theta, 1e-3) is not None
    assert gauss_newton_step(problem, e._replace(g=np.nan * e.g), moves, theta, 1e-3) is None


def test_no_log_is_left_out_of_squares_that_rounding_leaves_below_zero() -> None:
    problem, moves, theta = believed_heavier()
    e = least_squares(problem, moves, theta, most_steps=0).evaluation
    logs = [[0]]
    assert steps_without(problem, e, moves, theta, logs, np.inf)[0] is not None
    problem = replace(problem, prior=np.zeros_like(problem.prior))
    assert steps_without(problem, e._replace(H=-1e25 * e.H), moves, theta, logs, 1.0) == [None]
