"""Secant steps of a nonsmooth cost."""

import pytest

from rwjax.fitting.multiple_shooting import least_squares
from rwjax.fitting.nonsmooth import secant_steps
from tests.fitting.heavier import believed_heavier


def test_secant_steps_heed_a_prior() -> None:
    problem, moves, theta = believed_heavier()
    begun = least_squares(problem, moves, theta, most_steps=0)
    found = secant_steps(begun)
    again = least_squares(problem, moves, found.theta, start=found.start, most_steps=0)
    assert found.cost < 0.2 * begun.cost and found.cost == pytest.approx(again.cost, rel=1e-9)
    assert found.theta[problem.names.index("axis.inertia")] == pytest.approx(0.12, rel=0.05)
