"""Runs cut into segments: every sample once, what a segment keeps of its run, and the run put together again."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log
from rwjax.logs.log import Segments
from rwjax.logs.segments import EARLIER_S, cut_up, put_together, runs_of, whole_runs
from tests.systems import record

TIME = 3.0 + np.arange(2001) * 0.01


def _run(seconds: float, name: str = "a.csv", **more: object) -> Log:
    log = record(TIME, np.sin(TIME), {"yaw_rad": np.cos(TIME)}, **more)
    return replace(log, name=name, segments=Segments(seconds, "of a reason"))


def test_a_run_is_cut_into_equal_segments_no_longer_than_asked_and_loses_no_sample() -> None:
    log = _run(3.0)
    parts = cut_up([log])
    assert [part.segments.number for part in parts if part.segments] == list(range(7))  # 20 s in parts of 3 s or less
    assert all(np.ptp(part.time) < 20.0 / 7.0 for part in parts)
    assert np.array_equal(np.concatenate([part.time for part in parts]), TIME)
    assert {part.name for part in parts} == {"a.csv"} and {part.origin for part in parts} == {3.0}


def test_a_segment_keeps_the_command_before_it() -> None:
    last = cut_up([_run(3.0)])[-1]
    before, command = last.earlier
    assert before[-1] == pytest.approx(last.time[0] - 0.01) and np.array_equal(command, np.sin(before))
    assert EARLIER_S - 0.02 < last.time[0] - before[0] < EARLIER_S  # and of an hour no more than that


def test_whole_runs_stay_the_logs_that_they_are() -> None:
    undecided, whole = replace(_run(1.0), segments=None), _run(np.inf)
    assert all(a is b for a, b in zip(cut_up([undecided, whole]), [undecided, whole], strict=True))


def test_a_segment_without_readings_belongs_to_the_one_before_it() -> None:
    y = np.cos(TIME)
    y[(TIME > 9.0) & (TIME < 14.0)] = np.nan
    log = replace(_run(2.0), outputs={"yaw_rad": y})
    parts = cut_up([log])
    assert all(np.isfinite(part.outputs["yaw_rad"]).sum() >= 10 for part in parts)
    assert np.array_equal(np.concatenate([part.time for part in parts]), TIME)
    assert len(parts) < 10


def test_segments_know_their_run_and_give_it_back() -> None:
    a, b = _run(3.0), _run(8.0, "b.csv", supply=12.0 + TIME)
    b = replace(b, left_out={"yaw_rad": np.array([4.0, 22.0])})
    parts = cut_up([a, b])
    assert list(runs_of(parts)) == [0] * 7 + [1] * 3
    for given, back in zip((a, b), whole_runs(parts), strict=True):
        assert np.array_equal(given.time, back.time) and np.array_equal(given.command, back.command)
        assert np.array_equal(given.outputs["yaw_rad"], back.outputs["yaw_rad"]) and back.name == given.name
    back = put_together(parts[7:])
    assert back.supply is not None and np.array_equal(back.supply, 12.0 + TIME)
    assert np.array_equal(back.left_out["yaw_rad"], [4.0, 22.0])


def test_the_later_part_of_a_run_is_a_run_of_its_own() -> None:
    log = _run(3.0)
    parts = cut_up([log.cut(0, 1334), log.cut(1334, 2001)])
    assert list(runs_of(parts)) == [0] * 5 + [1] * 3
