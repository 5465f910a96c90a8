"""Secant steps of a nonsmooth cost."""

import pytest

from rwjax.fitting.multiple_shooting import least_squares
from rwjax.fitting.nonsmooth import secant_steps
from tests.fitting.heavier import believed_heavier


def test_secant_steps_heed_a_prior() -> None:
    problem, moves, theta = believed_heavier()
    begun = least_squares(problem, moves, theta, most_steps=0)
    found, start, cost = secant_steps(problem, moves, theta, begun.start, problem.start_free, begun.cost)
    again = least_squares(problem, moves, found, start=start, most_steps=0)
    assert cost < 0.2 * begun.cost and cost == pytest.approx(again.cost, rel=1e-9)
    assert found[problem.names.index("axis.inertia")] == pytest.approx(0.12, rel=0.05)
