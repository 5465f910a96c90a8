"""Noise from the readings alone: what moves smoothly, jumps or repeats with the turn is not taken for it."""

import numpy as np
import pytest

from rwjax.logs.log import Log
from rwjax.logs.noise import noise_by_output, noise_level, pooled_noise, quantisation

RNG = np.random.default_rng(5)
TIME = np.arange(1000) * 0.01
WHITE = 0.01 * RNG.normal(size=len(TIME))
ANGLE = 150.0 * TIME + 3.0 * np.sin(2.0 * TIME)  # a quarter of a turn in a sample


@pytest.mark.parametrize("motion", [0.0 * TIME, np.sin(2.0 * TIME), np.where(TIME < 5.0, 0.0, 4.0), ANGLE])
def test_motion_is_no_noise(motion: np.ndarray) -> None:
    assert noise_level(motion + WHITE) == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize("error", [0.0, 0.1])
def test_what_repeats_with_the_turn_is_no_noise_of_an_angle(error: float) -> None:
    read = ANGLE + error * np.sin(ANGLE + 0.4) + 0.4 * error * np.cos(2.0 * ANGLE)
    assert noise_level(read + WHITE, turning=True) == pytest.approx(0.01, rel=0.15)
    assert error == 0.0 or noise_level(read + WHITE) > 0.03


def test_the_noise_of_an_angle_that_turns_slowly_is_no_pattern_of_it() -> None:
    slow = 3.0 * TIME + WHITE
    assert noise_level(slow, turning=True) == noise_level(slow)


def test_an_angle_that_hardly_turns_is_read_as_any_signal() -> None:
    slow = 0.5 * np.sin(2.0 * TIME) + WHITE
    assert noise_level(slow, turning=True) == noise_level(slow)


def log(outputs: dict[str, np.ndarray], resolution: dict[str, float]) -> Log:
    return Log("x", TIME, 0.0 * TIME, outputs, resolution, {}, False, None, 0.0)


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
