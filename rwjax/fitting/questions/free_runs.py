"""Logs beside their free runs: what questions are asked of."""

from dataclasses import replace

import numpy as np

from rwjax.fitting.problem import Problem
from rwjax.fitting.questions.likeness import Run
from rwjax.logs.log import Log
from rwjax.logs.segments import put_together, runs_of
from rwjax.simulation.batch import Batch, by_sample
from rwjax.simulation.free_run import free_run


def free_runs(problem: Problem, theta: np.ndarray, batch: Batch, start: np.ndarray) -> list[Run]:
    """The logs that are read, with their free runs.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        batch: The runs, laid out as those of the problem.
        start: Initial states `(l, n)` [SI].

    Returns:
        The runs, segments of one put together.
    """
    y = np.asarray(free_run(problem.structure, theta, start, batch, solver=problem.solver)[0])
    names = problem.structure.outputs
    runs = []
    for logs in numbers_of_runs(problem):
        segments = [problem.logs[k] for k in logs]
        samples = np.concatenate(
            [by_sample(problem.batch, k, y[k], len(log.time)) for k, log in zip(logs, segments, strict=True)]
        )
        whole = put_together(segments)
        simulated = {
            name: y for name, y in whole.outputs.items() if name in names
        }  # not a current of a rig without a motor
        runs.append(Run(replace(whole, outputs=simulated), {name: samples[:, j] for j, name in enumerate(names)}))
    return runs


def logs_read(problem: Problem) -> list[Log]:
    """The logs that are read, as whole runs.

    Args:
        problem: Logs and structure.

    Returns:
        One log of each run.
    """
    return [put_together([problem.logs[k] for k in run]) for run in numbers_of_runs(problem)]


def numbers_of_runs(problem: Problem) -> list[list[int]]:
    """Numbers of the logs that are read, run by run.

    Args:
        problem: Logs and structure.

    Returns:
        Of each run the numbers of its segments.
    """
    found: dict[int, list[int]] = {}
    for k in map(int, problem.logs_with_readings):
        found.setdefault(int(runs_of(problem.logs)[k]), []).append(k)
    return list(found.values())
