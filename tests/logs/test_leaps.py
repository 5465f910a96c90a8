"""Leaps of an angle are found with their time and both readings, and what moves, wraps or is sampled slowly has none."""

import numpy as np
import pytest

from rwjax.logs.leaps import MOST, leaps
from rwjax.logs.log import Log

T = np.arange(2000) * 0.01
MOTION = 2.0 * np.sin(0.8 * T) + 0.3 * np.sin(5.0 * T)
COUNT = 2.0 * np.pi / 2048


def of(y: np.ndarray, name: str = "yaw_rad", time: np.ndarray = T) -> Log:
    return Log("run", time, np.cos(time), {name: y}, {name: 0.0}, {}, False, None, 0.0)


def behind(*starts: float, by: float = 3.0) -> np.ndarray:
    return MOTION + by * sum(t <= T for t in starts)


@pytest.mark.parametrize("count", [0.0, COUNT])
@pytest.mark.parametrize("by", [3.0, -0.5, 1e9])
def test_an_angle_that_goes_on_from_another_place_leaps_there(by: float, count: float) -> None:
    y = behind(8.0, by=by)
    y = np.round(y / count) * count if count else y
    (found,) = leaps(of(y), "yaw_rad")
    assert (found.output, found.at) == ("yaw_rad", 8.0)
    assert found.after - found.before == pytest.approx(by, abs=0.05)
    assert found.says.startswith(f"yaw_rad leaps from {found.before:.4g} to {found.after:.4g} rad at 8 s and goes on")


def test_a_counter_that_is_set_to_0_leaps() -> None:
    y = np.where(T < 7.0, MOTION, MOTION - MOTION[700])
    (found,) = leaps(of(y), "yaw_rad")
    assert (found.at, found.after) == (7.0, 0.0)


def test_a_few_leaps_are_found_in_order_and_many_are_not() -> None:
    starts = [12.0, 3.0, 7.0, 15.0]
    assert [one.at for one in leaps(of(behind(*starts[:MOST])), "yaw_rad")] == sorted(starts[:MOST])
    assert leaps(of(behind(*starts)), "yaw_rad") == []


def test_a_rate_and_a_motion_in_a_gap_do_not_leap() -> None:
    y = behind(8.0)
    assert leaps(of(y, "yaw_rad_s"), "yaw_rad_s") == []
    assert leaps(of(y, time=np.where(T < 8.0, T, T + 1.0)), "yaw_rad") == []


def test_missing_readings_beside_a_leap_do_not_hide_it() -> None:
    y = np.where(np.arange(2000) % 3 == 1, np.nan, behind(8.0))
    assert len(leaps(of(y), "yaw_rad")) == 1


def test_a_quick_step_of_a_rig_that_hardly_moves_is_none() -> None:
    """A servo answers a step between two samples, and settles."""
    y = np.where(T < 8.0, 0.0, 1.0 - 0.05 * np.exp(-(T - 8.0) / 0.05))
    for noise in (0.0, 1e-3):
        assert leaps(of(y + noise * np.random.default_rng(1).normal(size=2000)), "yaw_rad") == []


def test_a_log_too_short_to_tell_has_none() -> None:
    assert leaps(of(behind(0.1)[:20], time=T[:20]), "yaw_rad") == []
