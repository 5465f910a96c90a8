"""Noise of each output: rounding, pooled over logs."""

import numpy as np
import pytest

from rwjax.logs.log import Log
from rwjax.logs.noise import noise_by_output, pooled_noise, quantisation
from rwjax.logs.noise_level import noise_level

RNG = np.random.default_rng(5)
TIME = np.arange(1000) * 0.01
WHITE = 0.01 * RNG.normal(size=len(TIME))
ANGLE = 150.0 * TIME + 3.0 * np.sin(2.0 * TIME)  # a quarter of a turn in a sample
LONG = np.random.default_rng(8).normal(size=200_000)


def log(outputs: dict[str, np.ndarray], resolution: dict[str, float]) -> Log:
    time = 0.01 * np.arange(len(next(iter(outputs.values()))))
    return Log("x", time, 0.0 * time, outputs, resolution, {}, False, None, 0.0)


def test_rounding_to_counts_has_the_variance_of_a_uniform_error() -> None:
    counted = log({"yaw_rad": WHITE, "current_A": WHITE}, {"yaw_rad": 0.6, "current_A": 0.0})
    assert quantisation(counted, "yaw_rad") == pytest.approx(np.std(RNG.uniform(-0.3, 0.3, 100_000)), rel=0.01)
    assert quantisation(counted, "current_A") == quantisation(counted, "none") == 0.0


def test_a_counted_reading_is_as_noisy_as_its_rounding_at_least() -> None:
    size = 0.1
    counted = {"yaw_rad": size * np.round(ANGLE / size), "wheel_rad": size * np.round((ANGLE + 100.0 * WHITE) / size)}
    found = noise_by_output(log(counted, dict.fromkeys(counted, size)))
    assert found["yaw_rad"] == size / np.sqrt(12.0)  # nothing but rounding
    assert found["wheel_rad"] == pytest.approx(1.0, rel=0.15)  # 100 times 0.01


def test_a_reading_that_never_changes_still_has_a_scale() -> None:
    assert 0.0 < noise_by_output(log({"current_A": np.full(1000, 5.0)}, {}))["current_A"] < 1e-8


def test_noise_is_pooled_by_the_mean_variance() -> None:
    one, two = log({"current_A": WHITE}, {}), log({"current_A": 3.0 * WHITE, "yaw_rad_s": WHITE}, {})
    alone = noise_by_output(one)["current_A"]
    pooled = pooled_noise((one, two))
    assert pooled["current_A"] == pytest.approx(alone * np.sqrt((1.0 + 9.0) / 2.0))
    assert pooled["yaw_rad_s"] == pytest.approx(alone)


@pytest.mark.parametrize(("noise", "counts_alone"), [(1.9, True), (2.1, False)])
def test_noise_counts_from_twice_the_rounding_on(noise: float, counts_alone: bool) -> None:
    size = np.sqrt(12.0)  # rounding of 1
    found = noise_by_output(log({"current_A": noise * LONG}, {"current_A": size}))["current_A"]
    assert found == pytest.approx(1.0 if counts_alone else noise, rel=0.02)


def test_a_reading_that_never_changes_has_a_billionth_of_its_size_as_noise() -> None:
    still = {"current_A": np.full(1000, -5.0), "yaw_rad": np.zeros(1000), "yaw_rad_s": np.full(1000, np.nan)}
    found = noise_by_output(log(still, {}))
    assert found["current_A"] == pytest.approx(5e-9, rel=0.01) and found["yaw_rad"] == found["yaw_rad_s"] > 0.0
    assert found["yaw_rad"] < 1e-9


def test_only_an_angle_that_turns_over_four_times_has_a_pattern_of_the_turn() -> None:
    for turns, told in ((3.5, False), (4.5, True)):
        angle = 2.0 * np.pi * turns * np.arange(60) / 59.0
        read = angle + 0.3 * np.sin(2.0 * angle)
        assert (noise_level(read, turning=True) < 0.5 * noise_level(read)) == told
    with_rate = log({"yaw_rad": read, "yaw_rad_s": read}, {})
    assert noise_by_output(with_rate)["yaw_rad"] < 0.5 * noise_by_output(with_rate)["yaw_rad_s"]
