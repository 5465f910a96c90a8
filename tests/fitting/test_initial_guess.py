"""What the first readings say of the initial state."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from rwjax.fitting.initial_guess import guess_initial_state, starts_at_rest
from rwjax.plant.from_rig import structure_of
from rwjax.rig.columns_section import Source
from tests.systems import record, wheel

TIME = np.arange(601) * 0.01


def test_an_offset_of_the_current_does_not_set_a_run_in_motion() -> None:
    u = np.where(TIME > 0.6, 3.0, 0.0)
    log = record(TIME, u, {"yaw_rad": np.zeros_like(TIME), "current_A": np.full_like(TIME, 0.02)})
    assert starts_at_rest(log)
    assert not starts_at_rest(record(TIME, u + 0.004, log.outputs))


def test_a_command_that_begins_with_the_last_of_the_first_readings_acts_after_them() -> None:
    """At 100 Hz the sample of 0.50 s belongs to the first half second, and what is commanded there does not."""

    def begins(sample: int) -> bool:
        return starts_at_rest(record(TIME, np.where(np.arange(601) >= sample, 3.0, 0.0), {"yaw_rad": np.zeros(601)}))

    assert begins(50) and not begins(49)
    rare = TIME[::40]  # two samples in the first half second: what is commanded there is all that there is to ask
    assert not starts_at_rest(record(rare, np.full_like(rare, 3.0), {"yaw_rad": np.zeros_like(rare)}))


def _wandering(correlation: float, rng: np.random.Generator) -> np.ndarray:
    """Noise of standard deviation 1 that is an autoregression of first order, at `TIME`."""
    return lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], rng.normal(size=200 + len(TIME)))[200:]


def _share_at_rest(
    motion: Callable[[float], np.ndarray],
    correlation: float = 0.0,
    name: str = "wheel_rad_s",
    noise: float = 1.0,
    count: int = 100,
) -> float:
    """Share of runs without a command that start at rest, of a motion that begins at any part of a turn [1], read with noise [1]."""
    rng, zero = np.random.default_rng(1), np.zeros_like(TIME)
    readings = (motion(k / count) + noise * _wandering(correlation, rng) for k in range(count))
    return float(np.mean([starts_at_rest(record(TIME, zero, {name: y})) for y in readings]))


def _swing(size: float, frequency: float) -> Callable[[float], np.ndarray]:
    return lambda part: size * np.sin(2.0 * np.pi * (frequency * TIME + part))


def _slows_down(size: float, within: float) -> Callable[[float], np.ndarray]:
    return lambda part: size * np.exp(-TIME / within)


@pytest.mark.parametrize(("correlation", "at_least"), [(0.0, 0.99), (0.5, 0.97), (0.8, 0.9)])
@pytest.mark.parametrize(("name", "noise"), [("wheel_rad_s", 1.0), ("wheel_rad", 1e-3)])
def test_noise_that_wanders_does_not_set_a_run_in_motion(
    correlation: float, at_least: float, name: str, noise: float
) -> None:
    assert _share_at_rest(lambda part: np.zeros_like(TIME), correlation, name, noise, 400) >= at_least


RATES = {
    "even": lambda part: np.full_like(TIME, 1.0),
    "comes to rest": lambda part: 6.0 * np.maximum(1.0 - TIME / 0.3, 0.0),
    "slows down": _slows_down(10.0, 0.1),
    **{f"swings at {f} Hz": _swing(7.0, f) for f in (1.0, 2.0, 4.0, 6.0, 8.0)},
}
"""Rates in units of their noise [1]."""
ANGLES = {
    "even": lambda part: 0.02 * TIME,
    "comes to rest": lambda part: 10.0 * np.where(TIME < 0.3, TIME - TIME**2 / 0.6, 0.15),
    "slows down": lambda part: -_slows_down(0.5, 0.1)(part),
    "a parabola": lambda part: 2.0 * TIME - 3.0 * TIME**2,
    **{f"swings at {f} Hz": _swing(0.3, f) for f in (0.5, 1.0, 1.5, 2.0, 3.0)},
}
"""Angles [rad], of which the noise is 1 mrad."""


@pytest.mark.parametrize("motion", RATES)
def test_a_rate_beside_white_noise_is_seen(motion: str) -> None:
    assert _share_at_rest(RATES[motion]) <= 0.02


@pytest.mark.parametrize("motion", ANGLES)
def test_an_angle_beside_white_noise_is_seen(motion: str) -> None:
    assert _share_at_rest(ANGLES[motion], name="wheel_rad", noise=1e-3) <= 0.02


@pytest.mark.parametrize("readings", [3, 5, 8, 11, 17])
def test_few_readings_are_asked_as_of_white_noise(readings: int) -> None:
    rng, time = np.random.default_rng(2), np.arange(60) * 0.5 / (readings - 1)

    def share(rate: float) -> float:
        runs = (record(time, 0.0 * time, {"wheel_rad_s": rate + rng.normal(size=60)}) for _ in range(300))
        return float(np.mean([starts_at_rest(run) for run in runs]))

    assert share(0.0) > 0.85 and share(20.0) == 0.0


def _two_readings(rate: np.ndarray, angle: np.ndarray, resolution: float, time: np.ndarray = TIME) -> bool:
    counted = np.round(angle / resolution) * resolution
    log = record(time, np.where(time >= 0.6, 3.0, 0.0), {"wheel_rad_s": rate, "wheel_rad": counted})
    return starts_at_rest(replace(log, resolution={"wheel_rad": resolution}))


COUNT = 2.0 * np.pi / 4096
LATER = np.where(TIME > 0.6, TIME - 0.6, 0.0)
"""A motion after the first 0.5 s [rad]."""


def test_a_rate_does_not_move_a_body_whose_angle_stands_still() -> None:
    offset = np.full_like(TIME, 0.5)
    assert not starts_at_rest(record(TIME, np.where(TIME >= 0.6, 3.0, 0.0), {"wheel_rad_s": offset}))
    assert _two_readings(offset, LATER, COUNT)
    assert _two_readings(offset, LATER + COUNT * (TIME > 0.3), COUNT)  # at the edge of two counts
    assert _two_readings(_swing(10.0, 1.0)(0.1), LATER, COUNT)  # noise that wanders so that it looks like a swing


def test_an_angle_that_does_not_say_so_does_not_overrule_a_rate() -> None:
    offset = np.full_like(TIME, 0.5)
    assert not _two_readings(offset, 0.5 * TIME, COUNT)  # it turns
    assert not _two_readings(offset, LATER, 2.0)  # its counts are too coarse for so slow a turn
    assert not _two_readings(offset, np.zeros_like(TIME), COUNT)  # it never turns: an encoder that is not connected
    fast = np.arange(3001) * 1e-3
    vibration = 20.0 * np.cos(60.0 * np.pi * fast)
    assert not _two_readings(vibration, vibration / (60.0 * np.pi), COUNT, fast)  # to and fro by many counts


def test_a_rate_without_its_sign_begins_with_that_of_the_angle_or_of_the_command() -> None:
    unsigned = replace(wheel(), sources={name: Source(name, unsigned=True) for name in ("wheel_rad_s", "current_A")})
    structure = structure_of(unsigned)
    speed, rate = np.full_like(TIME, 5.0), structure.states.index("Omega")
    for volts, sign in ((-3.0, -1.0), (3.0, 1.0)):
        log = record(TIME, np.full_like(TIME, volts), {"wheel_rad_s": speed, "current_A": speed})
        guess = guess_initial_state(structure, log, rest=False)[0]
        assert np.allclose([guess[rate], guess[structure.states.index("i")]], sign * 5.0)
        turning = record(TIME, np.full_like(TIME, volts), {"wheel_rad_s": speed, "wheel_rad": -5.0 * TIME})
        assert abs(guess_initial_state(structure, turning, rest=False)[0][rate] + 5.0) < 1e-9
