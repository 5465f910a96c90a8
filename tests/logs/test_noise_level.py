"""Noise from a signal alone: what moves smoothly, jumps or repeats with the turn is not taken for it."""

import numpy as np
import pytest

from rwjax.logs.noise_level import noise_level

RNG = np.random.default_rng(5)
TIME = np.arange(1000) * 0.01
WHITE = 0.01 * RNG.normal(size=len(TIME))
ANGLE = 150.0 * TIME + 3.0 * np.sin(2.0 * TIME)  # a quarter of a turn in a sample
LONG = np.random.default_rng(8).normal(size=200_000)


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
