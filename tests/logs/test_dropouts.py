"""Drop-outs are found by their leaps, and what rests, sticks, is zeroed or is sampled slowly is none."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.logs.dropouts import dropouts, equal_stretches, freezes, leaps_after_rests, without_dropouts
from rwjax.logs.log import Log

T = np.arange(2000) * 0.01
COUNT = 2.0 * np.pi / 2048
MOTION = 6.0 + 3.0 * np.sin(0.8 * T)
LOST = slice(300, 400)


def of_angle(y: np.ndarray, count: float = COUNT, time: np.ndarray = T) -> Log:
    rounded = count * np.round(y / count) if count else y
    command = 4.0 * np.cos(0.8 * time)
    return Log("run", time, command, {"yaw_rad": rounded}, {"yaw_rad": count}, {}, False, None, 0.0)


def of_rate(y: np.ndarray, command: np.ndarray) -> Log:
    return Log("run", T, command, {"wheel_rad_s": y}, {"wheel_rad_s": 0.0}, {}, False, None, 0.0)


def at(y: np.ndarray, where: slice, value: float) -> np.ndarray:
    out = y.copy()
    out[where] = value
    return out


@pytest.mark.parametrize(("value", "shown"), [(0.0, "0"), (20.0, "6519")])
def test_a_reading_that_leaps_there_and_back_is_named_with_its_value_and_time(value: float, shown: str) -> None:
    (found,) = dropouts(of_angle(at(MOTION, LOST, value)))
    assert (found.output, found.first, found.last) == ("yaw_rad", 300, 399)
    stays = f"yaw_rad is exactly {shown} counts from 3 to 3.99 s, and jumps there and back"
    assert found.says == f"{stays}: a dropout? Leave those cells empty"


def test_a_reading_in_si_is_shown_in_its_unit() -> None:
    noise = 1e-3 * np.random.default_rng(1).normal(size=len(T))
    (found,) = dropouts(of_angle(at(MOTION + noise, LOST, -1.0), 0.0))
    assert found.says.startswith("yaw_rad is exactly -1 rad from 3 to 3.99 s")


def test_two_drop_outs_are_both_found_and_missing_readings_beside_them_do_not_matter() -> None:
    y = at(at(MOTION, LOST, 0.0), slice(1500, 1520), 0.0)
    y = np.where(np.arange(len(T)) % 3 == 1, np.nan, y)
    assert [(found.first, found.last) for found in dropouts(of_angle(y))] == [(300, 399), (1500, 1518)]


def test_without_drop_outs_a_log_has_missing_readings_there_and_a_good_log_is_the_same() -> None:
    log = of_angle(at(MOTION, LOST, 0.0))
    cleaned = without_dropouts(log, dropouts(log))
    assert np.flatnonzero(np.isnan(cleaned.outputs["yaw_rad"])).tolist() == [*range(300, 400)]
    assert np.array_equal(cleaned.outputs["yaw_rad"][:300], log.outputs["yaw_rad"][:300])
    assert without_dropouts(cleaned, dropouts(cleaned)) is cleaned


def zeroed() -> np.ndarray:
    """An angle that comes to rest, and whose counter is set to 0 before it moves again."""
    return np.where(
        T < 3.0, 3.0 * np.sin(0.5 * np.pi * np.minimum(T, 3.0) / 3.0) + 2.0, np.where(T < 5.0, 0.0, T - 5.0)
    )


def set_anew(by: float) -> np.ndarray:
    """An angle that rests for a second, and goes on from there with a leap."""
    goes_on = np.where(T < 5.0, T, np.maximum(T - 1.0, 5.0))
    return 6.0 + 3.0 * np.sin(0.8 * goes_on) + np.where(T > 6.0, by, 0.0)


def hops() -> np.ndarray:
    """A fast servo that is sampled slowly: from goal to goal between two samples."""
    return np.where((T % 4.0) < 2.0, 0.0, 1.5)


def creeps(by: float) -> np.ndarray:
    """A servo between two goals that is sampled slowly: most of the way in one sample, the rest in some more."""
    goal, y = np.where((np.arange(len(T)) // 30) % 2 == 0, 0.5, -0.5), np.full(len(T), 0.5)
    for k in range(1, len(T)):
        y[k] = goal[k] + (y[k - 1] - goal[k]) * np.exp(-by)
    return y


GOOD = {
    **{f"a servo that creeps to its goal by {by}": creeps(by) for by in (1.2, 1.5, 2.0, 4.0)},
    "a sensor that hangs at its last reading, which a rest may look like": at(MOTION, LOST, MOTION[299]),
    "a motion": MOTION,
    "rests between motions": np.where(
        (T > 5.0) & (T < 8.0), MOTION[500], np.where(T < 5.0, MOTION, MOTION[500] + 0.1 * (T - 8.0))
    ),
    "a counter that is set to 0 at rest": zeroed(),
    "a counter that is set anew between motions": set_anew(50.0),
    "a start within a sample that is twice as fast as any other": set_anew(0.05),
    "a servo that hops": hops(),
    "a servo that hops beside jitter": hops() + COUNT * (np.random.default_rng(2).random(len(T)) < 0.01),
    "a wrapped angle": np.mod(9.0 * MOTION, 2.0 * np.pi),
    "nothing but 0": np.zeros(len(T)),
    "0 at the start, before the sensor answers": at(MOTION, slice(0, 100), 0.0),
}


@pytest.mark.parametrize("name", GOOD)
def test_what_a_rig_may_do_is_no_drop_out(name: str) -> None:
    assert dropouts(of_angle(GOOD[name])) == []


def test_a_rest_that_the_logger_paused_in_is_no_drop_out() -> None:
    y = at(MOTION, LOST, 0.0)
    assert dropouts(of_angle(y)) and not dropouts(of_angle(y, time=np.where(np.arange(len(T)) > 399, T + 3.0, T)))


def test_a_rate_that_friction_holds_at_small_commands_is_no_drop_out_and_one_under_a_large_command_is() -> None:
    command = 4.0 * np.sin(0.8 * T)
    turns = np.where(np.abs(command) > 1.5, 10.0 * np.sign(command) * (1.0 + np.abs(command)), 0.0)
    turns += np.where(turns != 0.0, 0.02 * np.random.default_rng(3).normal(size=len(T)), 0.0)
    assert dropouts(of_rate(turns, command)) == dropouts(of_rate(np.abs(turns), command)) == []
    (found,) = dropouts(of_rate(at(turns, slice(180, 200), 0.0), command))
    assert found.says.startswith("wheel_rad_s is exactly 0 rad/s from 1.8 to 1.99 s")


def test_a_stretch_with_torque_off_is_no_drop_out() -> None:
    log = of_angle(at(MOTION, LOST, 0.0))
    off = replace(log, enabled=(T < 3.0) | (T >= 4.0))
    assert dropouts(log) and not dropouts(off)


def test_equal_readings_are_found_by_their_first_and_last() -> None:
    assert equal_stretches(np.array([1.0, 1.0, 2.0, 3.0, 3.0, 3.0])).tolist() == [[0, 1], [3, 5]]
    assert equal_stretches(np.array([1.0, np.nan, np.nan])).tolist() == []


FREEZE = slice(500, 801)


def frozen_at(y: np.ndarray, count: float = COUNT) -> Log:
    return of_angle(at(y, FREEZE, float(y[500])), count)


@pytest.mark.parametrize("count", [COUNT, 0.0])
def test_readings_that_stand_still_and_jump_to_where_they_would_be_are_a_freeze(count: float) -> None:
    (found,) = freezes(frozen_at(MOTION, count))
    assert (found.output, found.first, found.last) == ("yaw_rad", 500, 800)
    assert found.says.startswith("yaw_rad stands still from 5 to 8 s while the command changes, then jumps by ")
    y = frozen_at(MOTION, count).outputs["yaw_rad"]
    by = y[801] - y[500]
    assert (f"by {abs(by) / count:.0f} counts: " if count else f"by {abs(by):.4g} rad: ") in found.says
    assert found.says.endswith("the sensor or the link stopped; leave those cells empty")
    assert freezes(of_angle(MOTION)) == []


def test_a_freeze_is_told_only_under_a_command_that_changes_with_torque_on_and_for_half_a_second() -> None:
    log = frozen_at(MOTION)
    assert freezes(replace(log, command=at(log.command, slice(450, 850), 2.0))) == []
    assert len(leaps_after_rests(replace(log, command=at(log.command, slice(450, 850), 2.0)))) == 1
    assert freezes(replace(log, enabled=(T < 6.0).astype(float))) == []
    assert freezes(replace(log, time=np.where(T > 8.005, T + 3.0, T))) == []  # it may turn as far in a gap
    for last, many in ((550, 0), (551, 1)):
        still = at(MOTION, slice(500, last), float(MOTION[500]))
        assert len(freezes(of_angle(still))) == many


def test_two_freezes_are_both_told() -> None:
    twice = at(at(MOTION, FREEZE, float(MOTION[500])), slice(1200, 1400), float(MOTION[1200]))
    assert [found.first for found in freezes(of_angle(twice))] == [500, 1200]


def test_a_rig_that_friction_or_a_stop_holds_is_not_frozen() -> None:
    rate, angle, held = 0.0, np.zeros(2000), np.zeros(2000)
    for k in range(1, 2000):  # sticks below 2 V
        u = 4.0 * np.cos(0.8 * T[k])
        moves = abs(u) > 2.0 or abs(rate) > 0.04
        rate = rate + 0.01 * (u - 2.0 * np.sign(rate if rate else u) - 0.2 * rate) if moves else 0.0
        angle[k] = angle[k - 1] + 0.01 * rate
        held[k] = np.clip(angle[k], -0.5, 0.2)
    for y in (angle, held, np.clip(MOTION, 4.0, 7.0)):
        assert len(equal_stretches(of_angle(y).outputs["yaw_rad"])) and freezes(of_angle(y)) == []
        slow = slice(0, 2000, 10)
        assert freezes(of_angle(y[slow], time=T[slow])) == []


def test_slips_of_one_sample_between_rests_are_no_freezes() -> None:
    slips = np.floor(MOTION / 0.3) * 0.3
    slips[1000:] += 2.0
    assert freezes(of_angle(slips)) == []
