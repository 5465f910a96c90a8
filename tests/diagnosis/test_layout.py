"""Layout: logs by number, those that are fitted and those that are held out."""

from dataclasses import replace

import numpy as np

from rwjax.diagnosis.layout import brief, laid_out
from rwjax.diagnosis.settings import LengthSettings
from rwjax.fitting.segments import with_segments
from tests.diagnosis.several_runs import RIG, run_of
from tests.systems import platform, record


def test_of_unmarked_runs_each_is_held_out_in_turn_and_all_are_trained_on() -> None:
    found = laid_out(RIG, [run_of(k, {}) for k in range(3)])
    assert found.rule == "leave-one-run-out"
    assert {test for _, test in found.folds} == {(0,), (1,), (2,)}
    assert all({*train} | {*test} == {0, 1, 2} and not {*train} & {*test} for train, test in found.folds)
    assert found.train == found.train_runs == (0, 1, 2)


def test_of_marked_runs_those_alone_are_held_out() -> None:
    logs = [replace(run_of(k, {}), validate=k == 1) for k in range(3)]
    found = laid_out(RIG, logs)
    ((train, test),) = found.folds
    names = [log.name for log in found.logs]
    assert {names[k] for k in test} == {"1.csv"} and {names[k] for k in train} == {"0.csv", "2.csv"}
    assert {names[k] for k in found.train} == {"0.csv", "2.csv"} == {found.runs[k].name for k in found.train_runs}


def test_segments_of_a_run_are_numbered_one_after_the_other_and_stay_on_one_side() -> None:
    found = laid_out(RIG, with_segments(RIG, [run_of(k, {}) for k in range(2)], 3.0))
    assert len(found.logs) > len(found.runs) == 2 and found.train == tuple(range(len(found.logs)))
    for train, test in found.folds:
        assert {found.logs[k].name for k in train}.isdisjoint(found.logs[k].name for k in test)


def test_of_logs_whose_derivatives_a_search_cannot_hold_fewer_samples_and_then_fewer_runs_are_taken() -> None:
    rig, time = platform(), 0.01 * np.arange(1000)  # 2 states and 1 free number: 6 derivatives of each reading
    logs = [replace(record(time, np.sin(time)), name=f"{k}.csv") for k in range(40)]
    limits = LengthSettings(derivatives=120_000, coarsest_s=0.02)
    assert brief(rig, logs[:20], limits) == (tuple(logs[:20]), [])
    fewer, (thinner, some) = brief(rig, logs, replace(limits, derivatives=90_000))
    assert {len(log.time) for log in fewer} == {500} and len(fewer) == 30
    assert "one of every 2" in thinner and some.startswith("of 40 logs 30 were taken")
    assert len(brief(rig, logs, replace(limits, derivatives=1))[0]) == limits.fewest_runs
