"""Outliers: what cannot be is left out, what a body can do is kept."""

import numpy as np
import pytest

from rwjax.fit.rig_fit import fit_rig
from rwjax.log import read_log, write_log
from rwjax.outliers import MOST, outliers
from tests.systems import record, run, wheel

TIME = np.arange(1500) * 0.01
COMMAND = np.where(TIME > 0.6, 6.0 * np.sign(np.sin(1.3 * TIME)), 0.0)
RATE = run(wheel(), record(TIME, COMMAND, {"wheel_rad_s": TIME}), {})["wheel_rad_s"]


def spoilt(y: np.ndarray, share: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Readings of which a share, in groups of one to three, is replaced by anything up to five times their range."""
    bad = np.zeros(len(y), bool)
    for start in rng.choice(np.arange(10, len(y) - 10, 12), size=int(share * len(y) / 2), replace=False):
        bad[start : start + rng.integers(1, 4)] = True
    size = 5.0 * np.ptp(y)
    return np.where(bad, rng.uniform(0.4, 1.0, len(y)) * size * rng.choice([-1.0, 1.0], len(y)), y), bad


@pytest.mark.parametrize("seed", range(5))
def test_what_lies_far_outside_its_surroundings_is_found_and_nothing_else(seed: int) -> None:
    rng = np.random.default_rng(seed)
    y, bad = spoilt(RATE + rng.normal(0.0, 0.5, len(RATE)), 0.02, rng)
    found = outliers(y)
    assert np.array_equal(found, bad)


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
    assert not outliers(y).any()


def test_a_current_may_follow_its_command_within_a_sample() -> None:
    command = np.where(np.arange(400) % 100 == 50, 8.0, 0.0)
    current = command + np.random.default_rng(0).normal(0.0, 0.01, 400)
    assert outliers(current).sum() == 4 and not outliers(current, command).any()


def test_many_are_no_exceptions() -> None:
    y = np.where(np.arange(700) % 7 == 3, 100.0, 0.01 * np.random.default_rng(0).normal(size=700))
    assert not outliers(y).any() and 1.0 / 7.0 > MOST


def test_a_fit_is_as_good_as_without_them_and_says_so(tmp_path) -> None:
    rng = np.random.default_rng(3)
    clean = RATE + rng.normal(0.0, 0.5, len(RATE))
    wrong, _ = spoilt(clean, 0.02, rng)
    found = {}
    for name, y in (("clean", clean), ("wrong", wrong)):
        write_log(tmp_path / f"{name}.csv", {"time_s": TIME, "voltage_V": COMMAND, "wheel_rad_s": y})
        found[name] = fit_rig(wheel(), [read_log(tmp_path / f"{name}.csv", wheel())])
    assert any("of the readings of wheel_rad_s are outliers" in note for note in found["wrong"].notes)
    assert not any("outliers" in note for note in found["clean"].notes)
    for name, error in found["clean"].uncertainty.standard_error.items():
        assert abs(found["wrong"].rig.values[name] - found["clean"].rig.values[name]) < error, name
