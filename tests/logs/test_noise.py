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


LONG = np.random.default_rng(8).normal(size=200_000)


def test_the_size_of_white_noise_is_found_to_a_percent() -> None:
    assert noise_level(LONG) == pytest.approx(1.0, rel=0.01)
    signal = np.where(np.arange(len(LONG)) % 10 == 3, np.nan, LONG)
    assert noise_level(signal) == noise_level(signal[np.isfinite(signal)])


def test_a_fifth_of_the_differences_may_be_anything() -> None:
    jumps = np.cumsum(np.where(np.arange(len(LONG)) % 40 == 7, 1e3, 0.0))  # 4 of 40 third differences see each
    assert noise_level(LONG + jumps) == pytest.approx(1.0, rel=0.2)


def test_a_signal_too_short_has_no_noise_that_could_be_told() -> None:
    assert noise_level(LONG[:10]) == 0.0 < noise_level(LONG[:11])  # eight third differences at least
    assert noise_level(np.zeros(0)) == noise_level(np.full(20, np.nan)) == 0.0


def test_a_motion_sampled_slowly_does_not_count_in_higher_orders() -> None:
    swing = np.sin(0.5 * np.arange(2000))  # twelve samples a turn
    assert noise_level(swing + 0.001 * LONG[:2000]) < 0.3 * np.std(np.diff(swing, n=3)) / np.sqrt(20.0)


def test_counts_that_hardly_change_still_have_noise() -> None:
    """Nine of ten differences are 0: the rest, without the largest 2 %, says how large the noise is."""
    rare = np.where(np.arange(4000) % 60 == 11, 1.0, 0.0)  # each moves four of 60 third differences: 1, 3, 3 and 1
    largest = np.sort(np.tile([1.0, 3.0, 3.0, 1.0], 67))[: int(0.98 * 3997) - 3997]
    expected = np.sqrt(np.sum(largest**2) / int(0.98 * 3997) / 20.0)
    assert noise_level(rare) <= expected * 1.05 and noise_level(rare) > 0.0


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
