"""Leaps of an angle are found with their time and both readings, and what moves, wraps or is sampled slowly has none."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.logs.leaps import MOST, leaps
from rwjax.logs.log import Log

T = np.arange(2000) * 0.01
MOTION = 2.0 * np.sin(0.8 * T) + 0.3 * np.sin(5.0 * T)
COUNT = 2.0 * np.pi / 2048


def of(y: np.ndarray, name: str = "yaw_rad", time: np.ndarray = T, command: np.ndarray | None = None) -> Log:
    given = np.cos(time) if command is None else command
    return Log("run", time, given, {name: y}, {name: 0.0}, {}, False, None, 0.0)


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


def test_a_way_that_takes_two_samples_is_a_motion() -> None:
    assert leaps(of(behind(8.0, 8.01)), "yaw_rad") == []


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


def served(step: float, fastest: float) -> Log:
    """A servo at 20 Hz that follows a ramp, and a step of its goal at 15 s as fast as it can [rad, rad/s]."""
    t = np.arange(600) * 0.05
    goal = 0.1 * t + np.where(t < 15.0, 0.0, step)
    y = goal.copy()
    for k in range(1, 600):
        y[k] = y[k - 1] + np.clip(goal[k - 1] - y[k - 1], -0.05 * fastest, 0.05 * fastest)
    return replace(of(y, time=t, command=goal), input="goal_rad")


@pytest.mark.parametrize(("step", "fastest"), [(0.6, 5.0), (0.2, 50.0)])
def test_what_a_servo_does_when_its_goal_jumps_is_none(step: float, fastest: float) -> None:
    assert leaps(served(step, fastest), "yaw_rad") == []
    on_a_ramp = served(0.0, fastest)
    y = on_a_ramp.outputs["yaw_rad"] + np.where(on_a_ramp.time < 20.0, 0.0, step)
    assert [one.at for one in leaps(replace(on_a_ramp, outputs={"yaw_rad": y}), "yaw_rad")] == [20.0]


@pytest.mark.parametrize("count", [0.0, COUNT])
def test_a_counter_that_is_set_anew_at_rest_leaps_unless_the_command_changes_meanwhile(count: float) -> None:
    """Where it changes, the sensor may have hung and catches up."""
    at = np.clip(T, None, 8.0) + np.clip(T - 10.0, 0.0, None)
    motion = 2.0 * np.sin(0.8 * at) - np.where(T < 9.0, 0.0, 3.0)
    y = np.round(motion / count) * count if count else motion
    still = np.where((T < 8.0) | (T > 10.0), np.cos(T), 0.0)
    assert [one.at for one in leaps(of(y, command=still), "yaw_rad")] == [9.0]
    assert leaps(of(y), "yaw_rad") == []


@pytest.mark.parametrize("counts", [512, 1024, 4096])
def test_a_coarse_counter_that_is_sampled_fast_leaps(counts: int) -> None:
    t = np.arange(20_000) * 1e-3
    y = 2.0 * np.sin(0.8 * t) + 0.3 * np.sin(5.0 * t) + np.where(t < 8.0, 0.0, 3.0)
    count = 2.0 * np.pi / counts
    (found,) = leaps(of(np.round(y / count) * count, time=t), "yaw_rad")
    assert found.at == pytest.approx(8.0, abs=0.01)


@pytest.mark.parametrize("readings", [[], [1.0], [1.0, np.nan, 5.0], [np.nan] * 30, [2.0] * 30, [0.0, 9.0] * 10])
def test_a_log_too_short_to_tell_has_none(readings: list[float]) -> None:
    assert leaps(of(np.array(readings), time=T[: len(readings)]), "yaw_rad") == []
