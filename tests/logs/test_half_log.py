"""One half of a log with two axes as the log of a `reaction` rig."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from rwjax.logs.half_log import half_log
from rwjax.logs.read import read_log
from rwjax.logs.write import write_log
from rwjax.rig.half_rig import half_rig
from tests.two_axes import GIMBAL, GRAVITY, TILTING, two_axis

WHOLE = two_axis(GIMBAL + GRAVITY + TILTING)
T = 0.01 * np.arange(60)
READ = {"time_s": T, "voltage_1_V": np.sin(T), "voltage_2_V": np.cos(T), "yaw_rad": T, "pitch_counts": np.zeros(60)}


def test_a_log_has_two_commands_and_each_half_is_one_of_a_reaction_rig(tmp_path: Path) -> None:
    rig = replace(WHOLE, counts_per_rev={"pitch": 1000.0})
    write_log(tmp_path / "log.csv", READ)
    log = read_log(tmp_path / "log.csv", rig)
    assert log.command.shape == (60, 2) and {*log.outputs} == {"yaw_rad", "pitch_rad"}
    late = log.cut(20, 60)
    assert late.earlier[1].shape == (20, 2)
    pitch = half_log(late, 1)
    np.testing.assert_array_equal(pitch.command, np.cos(T)[20:])
    np.testing.assert_array_equal(pitch.earlier[1], np.cos(T)[:20])
    assert {*pitch.outputs} == {"yaw_rad"} and pitch.resolution == {"yaw_rad": 2.0 * np.pi / 1000.0}
    assert (
        half_rig(rig, 1).numbers["axis.gravity.torque"] == 0.15 and "gimbal.difference" not in half_rig(rig, 0).numbers
    )


def test_outliers_go_with_their_half(tmp_path: Path) -> None:
    write_log(tmp_path / "log.csv", READ | {"pitch_counts": np.where(np.arange(60) == 30, 1e4, np.arange(60))})
    log = read_log(tmp_path / "log.csv", replace(WHOLE, counts_per_rev={"pitch": 1000.0}))
    assert half_log(log, 0).left_out == {}
    np.testing.assert_array_equal(half_log(log, 1).left_out["yaw_rad"], T[[30]])
