"""Plateaus: where a speed has settled, and how well its mean is known."""

import numpy as np
import pytest
from scipy.signal import lfilter

from rwjax import Log
from rwjax.methods.plateaus import FEWEST, plateaus, without_standing
from tests.systems import record

TICK, TAU = 0.01, 0.3  # s
Q = 2.0 * np.pi / 2048


def approach(
    wait: float, levels: tuple[float, ...] = (100.0, 200.0, 50.0)
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, command and speed that goes to 20 times the command with the time constant `TAU`, each level held for `wait`."""
    n = round(wait / TICK)
    wanted = np.repeat(levels, n)
    keep = np.exp(-TICK / TAU)
    speed = lfilter([0.0, 1.0 - keep], [1.0, -keep], wanted)
    return np.arange(len(wanted)) * TICK, wanted / 20.0, np.asarray(speed)


def of_speed(t: np.ndarray, u: np.ndarray, y: np.ndarray) -> Log:
    return record(t, u, {"wheel_rad_s": y})


def test_a_mean_speed_is_that_of_the_settled_part() -> None:
    t, u, speed = approach(6.0)
    for seed in range(5):
        found, unsettled = plateaus(of_speed(t, u, speed + 0.5 * np.random.default_rng(seed).normal(size=len(t))))
        assert [p.volts for p in found] == [5.0, 10.0, 2.5] and unsettled == []
        for p, start in zip(found, (0.0, 6.0, 12.0), strict=True):
            assert p.begin - start > 5.0 * TAU  # there 0.7 % of the step are left, less than one reading's noise
            assert abs(p.speed.value - 20.0 * p.volts) < 4.0 * p.speed.error
            assert p.speed.error == pytest.approx(0.5 / np.sqrt((start + 6.0 - p.begin) / TICK), rel=0.35)


@pytest.mark.parametrize("wait", [1.0, 1.5])
@pytest.mark.parametrize("noise", [0.0, 0.05, 0.5])
def test_what_has_not_settled_is_left_out(wait: float, noise: float) -> None:
    t, u, speed = approach(wait)
    y = speed + noise * np.random.default_rng(0).normal(size=len(t))
    assert plateaus(of_speed(t, u, y)) == ([], pytest.approx([0.0, wait, 2.0 * wait]))


def test_counts_give_the_speed_that_they_count() -> None:
    t, u, speed = approach(6.0)
    jitter = 0.5 * np.random.default_rng(0).normal(size=len(t))  # counts; it keeps rounding from repeating
    angle = np.cumsum(speed) * TICK
    log = record(t, u, {"wheel_rad": Q * np.floor(angle / Q + jitter)}, resolution={"wheel_rad": Q})
    found, _ = plateaus(log)
    assert len(found) == 3
    for p in found:
        # closed form of a slope's error
        n = round((np.ceil(p.begin / 6.0 + 1e-9) * 6.0 - p.begin) / TICK)
        error = Q * np.sqrt(0.25 + 1.0 / 12.0) / (TICK * np.sqrt(n**3 / 12.0))
        assert abs(p.speed.value - 20.0 * p.volts) < 4.0 * p.speed.error
        assert p.speed.error == pytest.approx(error, rel=0.35)


@pytest.mark.parametrize("alike", [0.0, 0.5, 0.9])
def test_the_error_of_a_mean_knows_that_noise_is_correlated(alike: float) -> None:
    n = 4000
    white = np.random.default_rng(1).normal(size=n) * np.sqrt(1.0 - alike**2)
    y = 100.0 + np.asarray(lfilter([1.0], [1.0, -alike], white))
    (found,), _ = plateaus(of_speed(np.arange(n) * TICK, np.full(n, 5.0), y))
    count = n - round(found.begin / TICK)
    assert found.speed.error == pytest.approx(np.sqrt((1.0 + alike) / (1.0 - alike) / count), rel=0.3)


def test_a_slow_drift_is_no_plateau() -> None:
    t = np.arange(1000) * TICK
    y = 100.0 + 0.02 * t + 0.01 * np.random.default_rng(0).normal(size=len(t))  # as of a winding that warms
    assert plateaus(of_speed(t, np.full_like(t, 5.0), y)) == ([], [0.0])


def test_a_voltage_may_be_measured_with_noise_and_a_ramp_has_no_plateau() -> None:
    t, u, speed = approach(6.0)
    rng = np.random.default_rng(0)
    y = speed + 0.5 * rng.normal(size=len(t))
    found, _ = plateaus(of_speed(t, u + 0.01 * rng.normal(size=len(t)), y))
    assert [p.volts for p in found] == pytest.approx([5.0, 10.0, 2.5], abs=0.003)
    assert plateaus(of_speed(t, 0.5 * t, y)) == ([], [])
    assert plateaus(of_speed(t[: FEWEST - 1], u[: FEWEST - 1], y[: FEWEST - 1])) == ([], [])


def test_missing_readings_cost_precision_only_and_other_logs_have_no_plateau() -> None:
    t, u, speed = approach(6.0)
    y = speed + 0.5 * np.random.default_rng(0).normal(size=len(t))
    y[::3] = np.nan
    current = np.where(t < 6.0, 0.2, 0.4)
    found, _ = plateaus(record(t, u, {"wheel_rad_s": y, "current_A": current}))
    assert [p.current.value for p in found if p.current] == pytest.approx([0.2, 0.4, 0.4])
    assert all(abs(p.speed.value - 20.0 * p.volts) < 4.0 * p.speed.error for p in found)
    assert plateaus(record(t, u, {"yaw_rad": speed})) == ([], [])


def test_a_wheel_that_stands_is_told_from_one_that_turns() -> None:
    t, u, speed = approach(6.0, (0.0, 100.0))
    y = speed + 0.5 * np.random.default_rng(0).normal(size=len(t))
    turning, standing = without_standing(plateaus(of_speed(t, u, y))[0])
    assert ([p.volts for p in turning], [p.volts for p in standing]) == ([5.0], [0.0])
