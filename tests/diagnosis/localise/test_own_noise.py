"""What the fitted rig's own free runs would have read."""

import numpy as np
import pytest
from scipy.stats import kstest

from rwjax.diagnosis.localise.own_noise import above, draws, rates
from tests.diagnosis.localise.measured import COMMAND, TIME, as_given, measured
from tests.systems import platform, record


def test_p_of_logarithms_is_even_where_nothing_is_planted() -> None:
    rng = np.random.default_rng(5)
    squares = rng.chisquare(60, size=(2000, 25))
    assert kstest([above(row[0], row[1:]) for row in squares], "uniform").pvalue > 1e-3


def test_draws_have_the_noise_of_the_readings_and_are_rounded_to_counts() -> None:
    rig = platform("viscous = 0.05")
    log = measured(rig, COMMAND, COMMAND, ("yaw_rad",), 0)
    fitted, clean = as_given(rig, log), np.linspace(0.0, 1.0, len(TIME))
    found = draws(fitted, log, clean, "yaw_rad", 3, np.random.default_rng(0)) - clean[:, None]
    assert np.std(found) == pytest.approx(fitted.problem.noise["yaw_rad"], rel=0.05)
    step = 0.01
    counted = record(TIME, COMMAND, {"yaw_rad": log.outputs["yaw_rad"]}, resolution={"yaw_rad": step})
    rough = draws(as_given(rig, counted), counted, clean, "yaw_rad", 2, np.random.default_rng(0))
    apart = np.diff(rough, axis=0) / step
    assert np.allclose(apart, np.round(apart), atol=1e-9) and np.any(apart)


def test_rates_are_those_of_the_plant() -> None:
    rig = platform("viscous = 0.05")
    log = record(TIME, COMMAND)
    fitted, w = as_given(rig, log), np.linspace(-2.0, 2.0, len(TIME))
    found = rates(fitted, log, fitted.theta, {"w": w}, COMMAND, 2048)
    assert found["psi"] == pytest.approx(w)
    assert found["w"] == pytest.approx((0.4 * COMMAND - 0.05 * w) / 0.1, rel=1e-6, abs=1e-6)
    many = rates(fitted, log, fitted.theta, {"w": np.stack([w, 2.0 * w], axis=1)}, COMMAND, 300)
    assert np.allclose(many["w"][:, 0], found["w"]) and many["w"].shape == (len(TIME), 2)
