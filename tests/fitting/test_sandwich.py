"""The score's covariance with and without correlation, and undetermined combinations."""

import numpy as np
import pytest

from rwjax.fitting.sandwich import meat, undetermined
from tests.fitting.logs import red


def test_of_white_residuals_it_is_the_normal_matrix() -> None:
    rng = np.random.default_rng(0)
    G = np.ones((20000, 1, 1))
    assert meat([G], [rng.normal(size=(20000, 1))])[0, 0] == pytest.approx(20000.0, rel=0.1)


def test_of_correlated_residuals_it_is_the_variance_of_their_sum() -> None:
    n, rho = 40000, 0.9
    found = meat([np.ones((n, 1, 1))], [red(n, rho, 1.0, 0)[:, None]])[0, 0]
    # the long-run variance of an AR(1) of unit variance; the Bartlett window leaves out a little of it
    assert found / n == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.25)


def test_logs_add_up() -> None:
    rng = np.random.default_rng(1)
    G, r = [rng.normal(size=(300, 2, 3)) for _ in range(2)], [rng.normal(size=(300, 2)) for _ in range(2)]
    assert meat(G, r) == pytest.approx(meat(G[:1], r[:1]) + meat(G[1:], r[1:]))


def test_a_score_of_any_size_is_within_the_range_of_numbers() -> None:
    rng = np.random.default_rng(3)
    G, r = rng.normal(size=(300, 1, 2)), red(300, 0.9, 1.0, 4)[:, None]
    assert meat([1e120 * G], [r]) == pytest.approx(1e240 * meat([G], [r]))


def test_numbers_of_an_undetermined_combination_are_named_and_others_are_not() -> None:
    J = np.random.default_rng(2).normal(size=(50, 3))
    J = np.column_stack([J, J[:, 0] * 1e3, np.zeros(50)])  # the fourth scales with the first, the fifth leaves no trace
    assert undetermined(J.T @ J).tolist() == [True, False, False, True, True]
