"""A log in memory: its stretches, what a user should know of it, and how it prints."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rwjax.logs.log import Log, with_earlier
from tests.logs.texts import HEADER


def test_cut_keeps_the_origin(log):
    run = log([HEADER, *(f"{k / 100 + 3},0,{k}" for k in range(20))])
    part = run.cut(4, 8).cut(1, 4)
    assert part.origin == 3.0 and part.time == pytest.approx([3.05, 3.06, 3.07])
    assert part.outputs["yaw_rad"] == pytest.approx(np.array([5, 6, 7]) * math.tau / 256)
    assert run.cut(0, 20).name == "run.csv" and run.cut(10, 20).name == "run.csv[3.1 s…]"


def run(n: int = 100) -> Log:
    t = 0.01 * np.arange(n)
    outputs = {"yaw_rad": np.where(t == t[3], np.nan, t), "current_A": -2.0 * t}
    return Log(
        "run.csv",
        t,
        np.where(t < 0.5, -6.0, 6.0),
        outputs,
        dict.fromkeys(outputs, 0.0),
        {"why": "a test"},
        True,
        None,
        0.0,
    )


def test_a_cut_keeps_what_came_before_it() -> None:
    part = run().cut(20, 60).cut(10, 30)
    np.testing.assert_array_equal(part.earlier[0], run().time[:30])
    np.testing.assert_array_equal(with_earlier(part.earlier[1], part.command), run().command[:50])


def test_commands_of_two_axes_are_joined_too() -> None:
    two = np.arange(12.0).reshape(6, 2)
    np.testing.assert_array_equal(with_earlier(two[:2], two[2:]), two)
    np.testing.assert_array_equal(with_earlier(np.zeros(0), two), two)  # nothing came before


def test_outliers_are_remarked_and_cut_with_the_log() -> None:
    log = replace(run(), left_out={"yaw_rad": np.array([0.03, 0.5]), "current_A": np.array([0.7])})
    assert log.remarks() == [
        "run.csv: outliers among the readings of yaw_rad, which are left out: 2, the first at 0.03 s",
        "run.csv: outliers among the readings of current_A, which are left out: 1, the first at 0.7 s",
    ]
    assert {name: times.tolist() for name, times in log.cut(10, 60).left_out.items()} == {"yaw_rad": [0.5]}


def test_a_log_prints_duration_rate_ranges_and_notes() -> None:
    assert (
        str(run())
        == """\
log `run.csv`: 0.99 s, 100 samples at 100 Hz, kept for validation
  command: -6 to 6 V
  yaw_rad: 0 to 0.99 rad, 1 missing
  current_A: -1.98 to 0 A
  # why: a test"""
    )
    silent = replace(run(), outputs={"yaw_rad": np.full(100, np.nan)}, notes={}, validate=False)
    assert str(silent).endswith("samples at 100 Hz\n  command: -6 to 6 V\n  yaw_rad: no reading, 100 missing")
