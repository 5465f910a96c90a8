"""Outliers: what cannot be is left out, what a body can do is kept."""

import numpy as np
import pytest

from rwjax.fitting.fit import fit
from rwjax.logs.noise_level import noise_level
from rwjax.logs.outliers import MOST, outliers
from rwjax.logs.read import read_log
from rwjax.logs.write import write_log
from tests.systems import platform, record, run, wheel

TIME = np.arange(1500) * 0.01
COMMAND = np.where(TIME > 0.6, 6.0 * np.sign(np.sin(1.3 * TIME)), 0.0)
RATE = run(wheel(), record(TIME, COMMAND, {"wheel_rad_s": TIME}), {})["wheel_rad_s"]


def spoilt(y: np.ndarray, share: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Readings of which a share, each by itself and the first and the last among them, is up to five ranges off."""
    bad = rng.random(len(y)) < share
    bad[[0, -1]] = True
    size = 5.0 * np.ptp(y)
    return np.where(bad, y + rng.uniform(0.4, 1.0, len(y)) * size * rng.choice([-1.0, 1.0], len(y)), y), bad


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("share", [0.005, 0.02])
def test_what_lies_far_outside_its_surroundings_is_found_and_nothing_else(seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    y, bad = spoilt(RATE + rng.normal(0.0, 0.5, len(RATE)), share, rng)
    found = outliers(TIME, y)
    assert not np.any(found & ~bad)
    assert np.sum(bad & ~found) <= 0.05 * np.sum(bad)


@pytest.mark.parametrize("at", [slice(0, 1), slice(1499, 1500), slice(700, 703), slice(500, 504, 3), slice(1496, 1499)])
def test_the_ends_neighbours_and_a_few_in_a_row_are_found(at: slice) -> None:
    y = RATE + np.random.default_rng(0).normal(0.0, 0.5, len(RATE))
    y[at] += 5000.0
    assert np.array_equal(np.flatnonzero(outliers(TIME, y)), np.arange(1500)[at])


@pytest.mark.parametrize(
    "y",
    [
        RATE,  # kinks at every reversal
        np.round(RATE / 50.0) * 50.0,  # coarse
        np.where(np.arange(1500) == 700, 1.0, 0.0),  # a single count
        np.cumsum(np.where(np.arange(1500) == 700, 1e3, 0.01)),  # a jump that stays
        np.random.default_rng(0).standard_t(4, 1500),  # heavy tails
        np.random.default_rng(0).normal(size=1500),
        np.zeros(1500),
    ],
)
def test_what_a_body_or_an_encoder_can_do_is_kept(y: np.ndarray) -> None:
    assert not outliers(TIME, y).any()


def test_a_current_or_a_rate_may_answer_its_command_by_a_leap() -> None:
    command = np.where(np.arange(1500) % 100 == 50, 8.0, 0.0)
    late = np.roll(command, 5) + np.random.default_rng(0).normal(0.0, 0.01, 1500)
    assert outliers(TIME, late).sum() == 15 and not outliers(TIME, late, command).any()


def test_a_slip_between_two_rests_is_kept() -> None:
    push = np.where(TIME % 1.0 < 0.015, 1.0, 0.0)  # moved and stopped by friction within three samples
    w = run(platform("coulomb = 0.3"), record(TIME, push, {"yaw_rad": TIME}), {})["yaw_rad_s"]
    assert np.max(np.abs(w)) > 0.01
    assert not outliers(TIME, w + np.random.default_rng(0).normal(0.0, 1e-4, len(w)), push).any()


def test_a_reading_between_dropouts_is_kept() -> None:
    swing = np.sin(2.0 * TIME)
    swing[400:520] = np.nan
    swing[460] = np.sin(2.0 * TIME[460])
    assert not outliers(TIME, swing).any()


ZIGZAG = np.where(np.arange(400) % 2 == 0, -1.0, 1.0)  # each reading differs from the last by 2
WIDTH = 3.0 * 2.0 + 8.0 * noise_level(ZIGZAG)


STEPPED = ZIGZAG + 1e5 * (np.arange(400) >= 300)  # a band so wide that only the surroundings speak


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("length", [1, 2, 3])
@pytest.mark.parametrize("at", [0, 3, 200], ids=str)
def test_an_outlier_lies_outside_by_three_changes_and_eight_times_the_noise(side: float, length: int, at: int) -> None:
    margin = WIDTH * (1.0 if at else length + 1.0)  # at an end there are only readings on one side
    for width, found in ((0.95, []), (1.05, [*range(at, at + length)])):
        y = STEPPED.copy()
        y[at : at + length] = side * (1.0 + width * margin)
        assert np.flatnonzero(outliers(TIME[:400], y)).tolist() == found
        assert np.array_equal(outliers(TIME[:400], y[::-1]), outliers(TIME[:400], y)[::-1])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_outliers_near_one_another_lie_outside_the_band_by_its_width_and_eight_times_the_noise(side: float) -> None:
    margin = 2.0 + 8.0 * noise_level(ZIGZAG)
    for width, found in ((0.95, []), (1.05, [200, 202, 205])):
        y = ZIGZAG.copy()
        y[[200, 202, 205]] = side * (1.0 + width * margin)
        assert np.flatnonzero(outliers(TIME[:400], y)).tolist() == found


def test_four_in_a_row_are_no_outliers() -> None:
    for length in (3, 4):
        y = ZIGZAG.copy()
        y[200 : 200 + length] = 100.0
        assert outliers(TIME[:400], y).sum() == (3 if length == 3 else 0)


@pytest.mark.parametrize(("gap", "found"), [(0.044, True), (0.046, False)])
def test_readings_are_compared_across_four_missing_ones_at_most(gap: float, found: bool) -> None:
    time = TIME[:400] + np.where(np.arange(400) > 201, gap - 0.01, 0.0)
    y = STEPPED.copy()
    y[200] = 1.2 * (1.0 + WIDTH)
    assert outliers(time, y).any() == found


@pytest.mark.parametrize(("share", "found"), [(0.045, True), (0.055, False)])
def test_more_than_a_twentieth_are_no_exceptions(share: float, found: bool) -> None:
    y = ZIGZAG.copy()
    bad = np.linspace(5, 390, int(share * 400)).astype(int)
    y[bad] = 1000.0
    assert np.array_equal(np.flatnonzero(outliers(TIME[:400], y)), bad if found else [])


def test_a_leap_is_an_answer_for_fifteen_samples() -> None:
    for late, found in ((0, False), (15, False), (16, True)):
        command = np.where(np.arange(400) >= 200, 5.0, 0.0)
        y = ZIGZAG.copy()
        y[200 + late] = 100.0
        for u in (command, np.stack([0.0 * command, command], axis=1)):
            assert outliers(TIME[:400], y, u).any() == found
    before = np.where(np.arange(400) == 199, 100.0, ZIGZAG)
    assert outliers(TIME[:400], before, command).any()


def test_the_unit_of_the_readings_says_nothing() -> None:
    y = np.where(np.arange(400) % 90 == 30, 60.0, ZIGZAG)
    found = outliers(TIME[:400], y)
    assert found.sum() == 5 and all(np.array_equal(outliers(TIME[:400], s * y), found) for s in (1e-9, -7.0, 1e9))


@pytest.mark.parametrize("n", [8, 9])
def test_too_few_readings_have_no_surroundings(n: int) -> None:
    y = np.zeros(20)
    y[:n] = ZIGZAG[:n]
    y[4] = 1000.0
    y[n:] = np.nan
    found = outliers(TIME[:20], y)
    assert found.shape == (20,) and not found.any()  # one of nine is more than a twentieth


def test_many_are_no_exceptions() -> None:
    y = np.where(np.arange(1500) % 7 == 3, 100.0, 0.01 * np.random.default_rng(0).normal(size=1500))
    assert not outliers(TIME, y).any() and 1.0 / 7.0 > MOST


def test_a_current_that_leaps_with_an_early_command_is_none() -> None:
    for first in range(1, 12):
        command = np.where(np.arange(200) < first, 0.0, 6.0)
        current = np.where(np.arange(200) < first, 0.0, 3.0) + 1e-3 * np.random.default_rng(first).normal(size=200)
        assert not outliers(0.01 * np.arange(200), current, command).any(), first


def test_a_fit_is_as_good_as_without_them_and_says_so(tmp_path) -> None:
    rng = np.random.default_rng(3)
    clean = RATE + rng.normal(0.0, 0.5, len(RATE))
    wrong, _ = spoilt(clean, 0.02, rng)
    found = {}
    for name, y in (("clean", clean), ("wrong", wrong)):
        write_log(tmp_path / f"{name}.csv", {"time_s": TIME, "voltage_V": COMMAND, "wheel_rad_s": y})
        found[name] = fit(wheel(), [read_log(tmp_path / f"{name}.csv", wheel())])
    assert any("outliers among the readings of wheel_rad_s" in note for note in found["wrong"].notes)
    assert not any("outliers" in note for note in found["clean"].notes)
    for name, error in found["clean"].uncertainty.standard_error.items():
        assert abs(found["wrong"].rig.values[name] - found["clean"].rig.values[name]) < error, name


def test_a_log_shorter_than_the_surroundings_of_a_reading_is_looked_through() -> None:
    few = np.array([2.0, 2.0, 0.03125, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])  # six differ from the one before
    assert np.sum(outliers(0.1 * np.arange(len(few)), few, None)) < len(few) / 2


def test_the_first_readings_of_a_step_from_rest_are_kept_and_a_lost_byte_there_is_found() -> None:
    noise = 1e-3 * np.random.default_rng(2).normal(size=300)
    current = np.where(np.arange(300) < 1, 0.0, 3.0) + noise  # the first reading is from before the step
    speed = 40.0 * (1.0 - np.exp(-TIME[:300] / 0.002)) + noise  # a small motor is at its speed within a sample
    for y in (current, -current, speed):
        for u in (np.full(300, 6.0), np.full((300, 2), -6.0)):
            assert not outliers(TIME[:300], y, u).any()
    lost = current.copy()
    lost[0] = 200.0
    assert np.flatnonzero(outliers(TIME[:300], lost, np.full(300, 6.0))).tolist() == [0]
    lost[150] = 200.0
    assert np.flatnonzero(outliers(TIME[:300], lost, np.full(300, 6.0))).tolist() == [0, 150]
    assert np.flatnonzero(outliers(TIME[:300], current, np.zeros(300))).tolist() == [0]  # nothing drives it


def test_a_reading_that_is_lost_soon_after_the_start_is_found_under_a_command_that_was_there_before() -> None:
    turns = 20.0 + 1e-3 * np.random.default_rng(2).normal(size=300)
    for k in (3, 5, 12):
        lost = turns.copy()
        lost[k] = 0.0
        assert np.flatnonzero(outliers(TIME[:300], lost, np.full(300, 6.0))).tolist() == [k]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("decay", [0.05, 0.1])
def test_an_inrush_in_the_first_reading_is_kept_and_a_lost_byte_there_is_found(sign: float, decay: float) -> None:
    noise = 1e-3 * np.random.default_rng(2).normal(size=300)
    current = sign * (0.3 + 12.0 * decay ** np.arange(300)) + noise
    volts = np.full(300, sign * 6.0)
    assert outliers(TIME[:300], current).any() and not outliers(TIME[:300], current, volts).any()
    assert outliers(TIME[:300], current, 0.0 * volts)[0]  # nothing drives it
    lost = sign * 0.3 + noise
    lost[0] = sign * 12.3  # and nothing that decays after it
    assert np.flatnonzero(outliers(TIME[:300], lost, volts)).tolist() == [0]
    speed = sign * 40.0 * (1.0 - np.exp(-TIME[:300] / 0.3)) + noise
    speed[0] = -sign * 500.0  # a motion that begins slowly comes nearer, too
    assert np.flatnonzero(outliers(TIME[:300], speed, volts)).tolist() == [0]


@pytest.mark.parametrize("tau", [0.08, 0.3, 3.0])
@pytest.mark.parametrize("noise", [1e-4, 1e-2, 0.05, 0.1])
@pytest.mark.parametrize("lost", [60.0, 1000.0])
def test_a_lost_byte_before_a_slow_motion_is_no_inrush(tau: float, noise: float, lost: float) -> None:
    """Its next readings come nearer by little more than the noise, or than a count."""
    t, rng = TIME[:300], np.random.default_rng(5)
    for y in (40.0 * (1.0 - np.exp(-t / tau)), -5.0 - 40.0 * np.exp(-t / tau)):
        for count in (0.0, noise, 4.0 * noise):
            read = y + noise * rng.normal(size=300)
            read = np.round(read / count) * count if count else read
            read[0] = -lost - 60.0
            assert outliers(t, read, np.full(300, 6.0))[0]


@pytest.mark.parametrize("second", [10.0, -0.5])
def test_two_readings_in_a_row_that_are_lost_are_no_inrush(second: float) -> None:
    """One begins slowly, the other one goes beyond where it settles."""
    lost = 0.3 + 1e-3 * np.random.default_rng(2).normal(size=300)
    lost[:2] = 12.3, second
    assert np.flatnonzero(outliers(TIME[:300], lost, np.full(300, 6.0))).tolist() == [0, 1]


def test_readings_that_begin_late_begin_with_no_inrush() -> None:
    late = 0.3 + 12.0 * 0.05 ** (np.arange(300.0) - 100.0) + 1e-3 * np.random.default_rng(2).normal(size=300)
    late[:100] = np.nan
    assert outliers(TIME[:300], late, np.full(300, 6.0))[100]
