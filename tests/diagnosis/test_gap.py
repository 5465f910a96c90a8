"""The gap: its closure, the interval of that, and the headline signal."""

import numpy as np
import pytest

from rwjax.diagnosis.gap import Gap, HeldOut, closure, gap, headline, held_out
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.settings import GapSettings
from tests.diagnosis.simulated import TIME, fits_of, true_log
from tests.systems import platform


def test_closure_is_the_share_of_the_gap_above_the_floor() -> None:
    assert closure(1.0, 0.2, 0.2) == 1.0
    assert closure(1.0, 1.0, 0.2) == 0.0
    assert closure(0.2, 0.2, 0.2) is None


def errors(square: np.ndarray, seconds: int) -> HeldOut:
    block = np.repeat(np.arange(seconds), len(square) // seconds).astype(float)
    return HeldOut({"yaw_rad": square}, {"yaw_rad": np.full(len(square), 0.01)}, {"yaw_rad": block}, {})


def test_the_interval_of_a_closure_narrows_with_the_number_of_blocks() -> None:
    rng, width = np.random.default_rng(0), []
    for seconds in (10, 160):
        block = 1.0 + rng.random(seconds).repeat(50)
        found = gap(
            errors(block, seconds),
            errors(0.2 * block + 0.05 * rng.random(len(block)), seconds),
            "yaw_rad",
            GapSettings(),
        )
        assert found.ci95 is not None and found.closed is not None
        assert found.ci95[0] < found.closed < found.ci95[1]
        width.append(found.ci95[1] - found.ci95[0])
    assert width[1] == pytest.approx(width[0] / 4.0, rel=0.6)  # as the root of sixteen times the blocks


def test_a_gap_of_no_size_has_no_closure() -> None:
    square = np.full(100, 0.01)
    found = gap(errors(square, 10), errors(square, 10), "yaw_rad", GapSettings())
    assert found == Gap(found.floor, found.floor, found.floor, None, None) and found.floor == pytest.approx(0.1)


def test_a_closure_that_no_resampling_gives_has_no_interval() -> None:
    found = gap(errors(np.full(100, np.inf), 10), errors(np.ones(100), 10), "yaw_rad", GapSettings())
    assert found.ci95 is None


def test_the_headline_is_the_output_furthest_above_its_floor() -> None:
    gaps = {"yaw_rad": Gap(2.0, 2.0, 1.0, 0.0, None), "current_A": Gap(0.3, 0.3, 0.1, 0.0, None)}
    assert headline(gaps) == "current_A"
    assert gaps["yaw_rad"].size == pytest.approx(np.sqrt(3.0))


def test_held_out_errors_of_a_true_rig_are_noise_and_their_floor_says_so() -> None:
    rig = platform()
    fits = fits_of(rig, true_log(rig))
    found = held_out(fits, Hypothesis(), [((0,), (0,))], with_floor=True)
    assert found.rms("yaw_rad") == pytest.approx(2e-4, rel=0.1)
    assert np.sqrt(np.mean(found.floor["yaw_rad"])) == pytest.approx(2e-4, rel=0.3)
    assert len(np.unique(found.block["yaw_rad"])) == 21 and len(found.error[0]["yaw_rad"]) == len(TIME)
