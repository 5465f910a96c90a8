"""Noise from the readings alone: what moves smoothly, jumps or repeats with the turn is not taken for it."""

import numpy as np
import pytest

from rwjax.logs.noise import noise_level

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
