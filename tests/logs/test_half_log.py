"""One half of a log with two axes as the log of a `reaction` rig."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax.logs.half_log import half_log
from rwjax.logs.log import Log
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


@pytest.mark.parametrize(("half", "axis", "k"), [(0, "yaw", 1), (1, "pitch", 2)])
def test_every_reading_of_a_half_has_the_name_of_a_reaction_rig(half: int, axis: str, k: int) -> None:
    names = {f"{axis}_rad": "yaw_rad", f"{axis}_rad_s": "yaw_rad_s", f"current_{k}_A": "current_A"}
    names |= {f"wheel_{k}_rad": "wheel_rad", f"wheel_{k}_rad_s": "wheel_rad_s"}
    other = [f"{name}_rad" for name in ("yaw", "pitch", "wheel_1", "wheel_2")]
    outputs = {name: j + T for j, name in enumerate(dict.fromkeys([*names, *other]))}
    resolution, left_out = {name: y[1] for name, y in outputs.items()}, {name: y[:2] for name, y in outputs.items()}
    command = np.stack([np.sin(T), np.cos(T)], axis=1)
    log = Log("two.csv", T, command, outputs, resolution, {"why": "x"}, True, None, 0.0, left_out=left_out)
    found = half_log(log, half)
    for of_half, whole in ((found.outputs, outputs), (found.resolution, resolution), (found.left_out, left_out)):
        assert {*of_half} == {*names.values()}
        assert all(np.array_equal(of_half[to], whole[name]) for name, to in names.items())
    assert np.array_equal(found.command, command[:, half]) and found.earlier[1].shape == (0,)
    assert (found.name, found.notes, found.validate) == ("two.csv", {"why": "x"}, True)
