"""Amplitude and pace of runs: little travel makes them faster, not still."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax.planning.amplitude import KEPT, LEVELS, moves, rounded_levels
from rwjax.planning.campaign import recommend
from rwjax.planning.designs import DESIGNS
from rwjax.planning.envelope import envelope
from tests.planning.campaign_rigs import SLIDE
from tests.systems import platform


@pytest.mark.slow
def test_little_travel_makes_runs_faster_not_still(tmp_path: Path) -> None:
    rig = SLIDE
    runs, remarks = recommend(rig, envelope(rig, 10.0, {"yaw_rad": 0.2}))
    played = {run.name.removesuffix("_1").removesuffix("_2").removesuffix("_3"): run for run in runs}
    assert {*DESIGNS} - {*played} == {"coast_slow", "coast_slow_back"}  # as large as those that are to be faster
    assert len(remarks) == 2 and "coast_slow (as coast_fast)" in remarks[0] and "bring it to the middle" in remarks[1]
    for name, run in played.items():
        assert 0.0 < run.reaches["yaw_rad"] <= 0.2, name
        assert run.experiment.period <= DESIGNS[name].period
    assert max(run.reaches["yaw_rad"] for run in runs) > 0.6 * KEPT * 0.2
    assert any(run.experiment.period < 0.5 * DESIGNS["square"].period for run in runs if run.name == "square")


def test_amplitudes_are_rounded_down_to_three_digits() -> None:
    levels = rounded_levels(np.array([1.0, 0.012345, 1234.5]), 0.5)
    assert levels.shape == (3, LEVELS)
    exact = np.array([[1.0], [0.012345], [1234.5]]) * np.linspace(0.5, 1.0, LEVELS)
    assert np.all(levels <= exact * (1.0 + 1e-9)) and np.all(levels > exact * 0.99)
    assert levels[:, -1] == pytest.approx([1.0, 0.0123, 1230.0]) and levels[0, 0] == 0.5


def test_a_run_moves_a_rig_where_its_encoder_shows_it_and_both_ways_where_that_is_asked() -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 200)
    rates = np.stack([np.sin(t), np.abs(np.sin(t)), 1e-4 * np.sin(t)])
    angles = np.cumsum(rates, axis=1) * (t[1] - t[0])
    moved = {"yaw_rad": angles, "yaw_rad_s": rates}
    both = np.array([True, True, True])
    fine = replace(platform(), counts_per_rev={"axis": 2048.0})
    assert moves(fine, moved, both).tolist() == [True, False, False]  # 20 counts are 0.06 rad
    assert moves(fine, moved, ~both).tolist() == [True, True, False]
    assert moves(platform(), moved, ~both).tolist() == [True, True, True]
