"""Logs beside their free runs: segments of a run are put together, and logs without readings left out."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.problem import pose
from rwjax.fitting.questions.free_runs import free_runs, logs_read, numbers_of_runs
from rwjax.logs.log import Log, Segments
from rwjax.logs.segments import cut_up
from rwjax.plant.from_rig import structure_of, theta_of
from tests.fitting.questions.runs import LOGS, RIG, beside


def test_a_free_run_is_that_of_the_rig_by_another_way() -> None:
    structure = structure_of(RIG)
    problem, theta = pose(structure, LOGS), theta_of(RIG, structure)
    for run, log in zip(free_runs(problem, theta, problem.batch, 0.0 * problem.start), LOGS, strict=True):
        assert run.log.name == log.name
        assert run.simulated["yaw_rad"] == pytest.approx(beside(log).simulated["yaw_rad"], abs=1e-6)


def test_segments_are_one_run_and_what_is_not_read_is_none() -> None:
    blind = replace(LOGS[1], name="blind", outputs={"yaw_rad": np.full(len(LOGS[1].time), np.nan)})
    logs: list[Log] = [replace(log, segments=Segments(5.0, "a test")) for log in (LOGS[0], blind, LOGS[2])]
    cut = cut_up(logs)
    problem = pose(structure_of(RIG), cut)
    assert len(cut) > 2 * len(logs) and [len(run) > 1 for run in numbers_of_runs(problem)] == [True, True]
    assert [(log.name, len(log.time)) for log in logs_read(problem)] == [(log.name, len(log.time)) for log in LOGS[::2]]
