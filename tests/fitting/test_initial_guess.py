"""What the first readings say of the initial state."""

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


def _share_at_rest(motion: np.ndarray, correlation: float, **more: np.ndarray) -> float:
    """Share of 200 runs that start at rest, of a wheel without a command whose rate is read with noise [1]."""
    rng, zero = np.random.default_rng(1), np.zeros_like(TIME)
    runs = (record(TIME, zero, {"wheel_rad_s": motion + _wandering(correlation, rng), **more}) for _ in range(200))
    return float(np.mean([starts_at_rest(run) for run in runs]))


@pytest.mark.parametrize(("correlation", "at_least"), [(0.0, 0.99), (0.5, 0.97), (0.8, 0.9)])
def test_noise_that_wanders_does_not_set_a_run_in_motion(correlation: float, at_least: float) -> None:
    assert _share_at_rest(np.zeros_like(TIME), correlation) >= at_least


MOTIONS = {
    "even": np.full_like(TIME, 1.0),
    "one that comes to rest": 4.0 * np.maximum(1.0 - 2.0 * TIME, 0.0),
    "a slow swing": 10.0 * np.sin(2.0 * np.pi * TIME + 0.5),
    "a fast swing": 12.0 * np.sin(8.0 * np.pi * TIME),
}


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_motion_beside_white_noise_is_seen(motion: str) -> None:
    assert _share_at_rest(MOTIONS[motion], 0.0) <= 0.02


def test_a_rate_does_not_move_a_body_whose_angle_stands_still() -> None:
    offset, count = np.full_like(TIME, 0.5), 2.0 * np.pi / 4096
    command = np.where(TIME >= 0.6, 3.0, 0.0)

    def starts(angle: np.ndarray, resolution: float = count) -> bool:
        counted = np.round(angle / resolution) * resolution
        log = record(TIME, command, {"wheel_rad_s": offset, "wheel_rad": counted})
        return starts_at_rest(replace(log, resolution={"wheel_rad": resolution}))

    assert not starts_at_rest(record(TIME, command, {"wheel_rad_s": offset}))
    assert starts(np.zeros_like(TIME)) and starts(count * (TIME > 0.3))  # it stands, or at the edge of two counts
    assert not starts(0.5 * TIME)  # it turns
    assert not starts(np.zeros_like(TIME), 2.0)  # a coarse angle does not show so slow a turn


def test_a_rate_that_wanders_does_not_move_a_body_whose_angle_stands_still() -> None:
    """Also where it wanders so that it looks like a swing."""
    assert _share_at_rest(MOTIONS["a slow swing"], 0.0, wheel_rad=np.zeros_like(TIME)) == 1.0


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
