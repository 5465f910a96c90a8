"""Coordinates: steps in logarithms and in units, bounds, and derivatives against differences."""

import numpy as np
import pytest

from rwjax.fitting.coordinates import LARGEST_LOG_STEP, SMALL_LOG_STEP, Coordinates, coordinates

THETA = np.array([2.0, -0.5, 7.0, 0.3])
FREE = np.array([True, True, False, True])
BOUNDS = np.array([[0.1, 10.0], [-1.0, 1.0], [0.0, 9.0], [0.0, 0.4]])
SIZE = np.array([2.0, 0.5, 7.0, 0.2])


def moves(prior: bool = False) -> Coordinates:
    return coordinates(THETA, FREE, BOUNDS, SIZE, prior=prior)


def test_a_positive_number_moves_by_a_factor_and_others_in_units_of_their_size() -> None:
    found = moves().move(THETA, np.array([np.log(1.5), 0.4, -0.1]))
    assert found == pytest.approx([3.0, -0.3, 7.0, 0.28], rel=1e-15)


def test_a_step_ends_at_the_bounds() -> None:
    found = moves().move(THETA, np.array([10.0, -10.0, 10.0]))
    assert found.tolist() == [10.0, -1.0, 7.0, 0.4]
    low, high = moves().on_bound(found)
    assert low.tolist() == [False, True, False] and high.tolist() == [True, False, True]
    assert moves().clip(np.array([0.0, 3.0, -1.0, 0.3])).tolist() == [0.1, 1.0, -1.0, 0.3]  # the third is not free


@pytest.mark.filterwarnings("error")
def test_a_number_without_end_is_on_no_bound_of_a_range_without_one() -> None:
    open_ended = coordinates(THETA, FREE, np.tile([-np.inf, np.inf], (4, 1)), SIZE)
    low, high = open_ended.on_bound(np.array([np.inf, -0.5, 7.0, 0.3]))
    assert not low.any() and not high[1:].any()


def test_slopes_are_those_of_differences() -> None:
    c, h = moves(), 1e-6
    by_difference = [
        ((c.move(THETA, h * e) - c.move(THETA, -h * e)) / (2.0 * h))[k] for k, e in zip(c.index, np.eye(3), strict=True)
    ]
    assert c.slope(THETA) == pytest.approx(by_difference, rel=1e-9)
    assert c.slope_at(THETA) == pytest.approx([*by_difference[:2], 1.0, by_difference[2]], rel=1e-9)


def test_with_a_prior_small_log_steps_are_in_proportion() -> None:
    small = 0.5 * SMALL_LOG_STEP
    assert moves(prior=True).move(THETA, np.array([small, 0.0, 0.0]))[0] == 2.0 * (1.0 + small)
    assert moves().move(THETA, np.array([small, 0.0, 0.0]))[0] == 2.0 * np.exp(small)


def test_only_logarithms_shorten_a_step() -> None:
    assert moves().shorten(np.array([-2.0 * LARGEST_LOG_STEP, 0.1, 0.0])) == pytest.approx(0.5)
    assert moves().shorten(np.array([0.1, 50.0, 50.0])) == 1.0


def test_a_held_number_is_gone() -> None:
    held = moves().without(1)
    assert held.index.tolist() == [0, 3] and held.size.tolist() == [2.0, 0.2]
    assert held.move(THETA, np.array([0.0, 0.5]))[3] == pytest.approx(0.4)
