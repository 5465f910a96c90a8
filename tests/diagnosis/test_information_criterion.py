"""The information criterion and the samples that count as independent."""

import numpy as np
import pytest

from rwjax.diagnosis.information_criterion import (
    correlation_time,
    effective_samples,
    information_criterion,
    residuals,
    sums_of_squares,
)
from rwjax.fitting.fit import fit
from tests.diagnosis.simulated import TIME, true_log
from tests.systems import platform


def test_correlation_time_of_a_first_order_process() -> None:
    rho, n = 0.8, 200_000
    noise = np.random.default_rng(0).normal(size=n)
    x = np.empty(n)
    x[0] = noise[0]
    for k in range(1, n):
        x[k] = rho * x[k - 1] + noise[k]
    assert correlation_time(x) == pytest.approx((1 + rho) / (1 - rho), rel=0.1)
    assert correlation_time(noise) == pytest.approx(1.0, abs=0.1)
    assert correlation_time(np.zeros(100)) == 1.0


def test_effective_samples_add_up_over_logs() -> None:
    steady = np.ones(100)  # one long stretch says one thing, however often it is read
    noise = np.random.default_rng(1).normal(size=10_000)
    found = effective_samples({"yaw_rad": [steady, noise], "current_A": [steady]})
    assert found["current_A"] == pytest.approx(100.0 / correlation_time(steady)) and found["current_A"] < 3.0
    assert found["yaw_rad"] == pytest.approx(found["current_A"] + len(noise) / correlation_time(noise))


def test_the_criterion_is_that_of_schwarz_and_akaike() -> None:
    n, squares = {"yaw_rad": 50.0, "current_A": 30.0}, {"yaw_rad": 80.0, "current_A": 20.0}
    fit = -25.0 * np.log(80.0) - 15.0 * np.log(20.0)
    assert information_criterion(squares, 0, 0, n) == pytest.approx(fit)
    assert information_criterion(squares, 3, 2, n) == pytest.approx(fit - 1.5 * np.log(80.0) - 2.0)
    halved = {"yaw_rad": 40.0, "current_A": 20.0}  # half the squares of 50 samples: 25 ln 2
    assert information_criterion(halved, 0, 0, n) - fit == pytest.approx(25.0 * np.log(2.0))


def test_a_run_that_left_the_range_of_numbers_has_an_infinite_sum() -> None:
    sums = sums_of_squares({"yaw_rad": [np.array([3.0, 4.0]), np.array([12.0])], "current_A": [np.array([1e200])]})
    assert sums == {"yaw_rad": 169.0, "current_A": np.inf}


def test_residuals_of_a_true_rig_are_white_and_of_the_noise_s_size() -> None:
    rig = platform()
    fitted = fit(rig, [true_log(rig)]).fit
    (found,) = residuals(fitted, [0])["yaw_rad"]
    assert found.shape == TIME.shape
    assert np.mean(found**2) == pytest.approx(1.0, abs=0.1) and correlation_time(found) < 1.5
