"""Free runs of a problem from the initial states of the first 0.5 s, and the floor that a perfect model would leave.

The model's own initial states are estimated by least squares over the first 0.5 s; nothing after it is considered. A run
that begins with input and rates indistinguishable from zero starts at rest. The floor has three parts: noise and
quantisation of the readings, the uncertainty of the initial state carried through the model, and the scatter of runs
that repeat one command.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.fitting.batched_runs import Simulating, Wanted, together
from rwjax.fitting.initial_guess import starts_at_rest
from rwjax.fitting.initial_state import initial_state_covariance, initial_states, moved_starts
from rwjax.fitting.problem import Problem
from rwjax.kinds import is_angle
from rwjax.logs.log import Log
from rwjax.simulation.batch import by_sample
from rwjax.simulation.free_run import free_run


@dataclass(frozen=True)
class Prediction:
    """Free run of one log.

    Attributes:
        log: Number of the log.
        outputs: Predicted readings `(time,)` [SI] at the log's times, by name, of every output that the problem keeps.
        start: Initial state `(n,)` [SI].
        floor: Standard deviation of what a perfect model would still leave `(time,)` [SI], for each logged output.
    """

    log: int
    outputs: dict[str, np.ndarray]
    start: np.ndarray
    floor: dict[str, np.ndarray]


def predict_logs(problem: Problem, theta: np.ndarray, *, with_floor: bool = True) -> list[Prediction]:
    """Free runs of all logs of a problem.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        with_floor: Whether to compute the floor.

    Returns:
        One prediction for each log.
    """
    return together([predicted(problem, theta, range(len(problem.logs)), with_floor=with_floor)])[0]


def predicted(
    problem: Problem, theta: np.ndarray, logs: Sequence[int], *, with_floor: bool
) -> Simulating[list[Prediction]]:
    """Free runs of some logs, with initial states by their readings alone, as a search beside others.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        logs: Numbers of the logs.
        with_floor: Whether to compute the floor.

    Yields:
        Free runs to simulate.

    Returns:
        One prediction for each of these logs.
    """
    problem = problem.only(logs)
    start, y, by_state = yield from _runs_and_secants(problem, theta, np.array(logs), with_floor)
    names = problem.structure.outputs
    found = []
    for k, readings, secants in zip(logs, y, np.moveaxis(by_state, 1, 0), strict=True):
        samples = by_sample(problem.batch, k, readings, len(problem.logs[k].time))
        floor = _floor(problem, k, secants) if with_floor else {}
        found.append(Prediction(k, {name: samples[:, j] for j, name in enumerate(names)}, start[k], floor))
    return found


def _floor(problem: Problem, k: int, secants: np.ndarray) -> dict[str, np.ndarray]:
    """Standard deviation of noise and initial state `(time,)` for each logged output of log `k`; secants `(n, w, q, y)`."""
    log, floor = problem.logs[k], {}
    through = np.moveaxis(secants, 0, -1) * problem.batch.weight[k][..., None]
    covariance = initial_state_covariance(problem, through, k)
    S = by_sample(problem.batch, k, through, len(log.time))
    for j, name in enumerate(problem.structure.outputs):
        if name in log.outputs:
            from_start = np.einsum("ta,ab,tb->t", S[:, j], covariance, S[:, j])
            floor[name] = problem.noise[name] * np.sqrt(1.0 + np.maximum(from_start, 0.0))
    return floor


def _runs_and_secants(
    problem: Problem, theta: np.ndarray, logs: np.ndarray, with_secants: bool
) -> Simulating[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Initial states `(l, n)` of all logs; of some logs readings `(l, w, q, y)` and secants `(n, l, w, q, y)`.

    The secants are by the initial states, 0 where none are asked for or a run leaves the range of numbers.
    """
    start = yield from initial_states(problem, theta)
    states, width, moved = moved_starts(problem, start) if with_secants else (np.zeros(0, int), start, [])
    windows = problem.batch.windows
    y = yield Wanted(problem, np.tile(theta, (1 + len(states), 1)), np.stack([start, *moved]), logs, windows)
    by_state = np.zeros((start.shape[1], *y.shape[1:]))
    with np.errstate(over="ignore", invalid="ignore"):
        change = (y[1:] - y[0]) / width[logs].T[states][..., None, None, None]
    by_state[states] = np.where(np.isfinite(change).all(axis=(1, 2, 3, 4), keepdims=True), change, 0.0)
    return start, y[0], by_state


def every_output(problem: Problem, theta: np.ndarray, start: np.ndarray) -> list[dict[str, np.ndarray]]:
    """Free runs with all outputs that the kind of rig has, those that no log holds among them.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI].

    Returns:
        For each log the outputs `(time,)` [SI] at its times, by name.
    """
    structure = problem.structure.with_every_output()
    y = np.asarray(free_run(structure, theta, start, problem.batch, solver=problem.solver)[0])
    found = [by_sample(problem.batch, k, y[k], len(log.time)) for k, log in enumerate(problem.logs)]
    return [dict(zip(structure.outputs, samples.T, strict=True)) for samples in found]


def repeatability(logs: tuple[Log, ...]) -> dict[str, list[tuple[int, np.ndarray]]]:
    """Scatter between runs of one command that all start at rest.

    Args:
        logs: The logs.

    Returns:
        For each output, pairs of a log's number and the variance `(time,)` [SI²] at its times, NaN where only one run
        has a reading.
    """
    groups: dict[tuple, list[int]] = {}
    for k, log in enumerate(logs):
        if not log.goes_on and starts_at_rest(log):  # a run that starts moving repeats only what moved alike
            times = np.round(log.time - log.time[0], 3)
            beside = (None if value is None else value.tobytes() for value in (log.enabled, log.supply))
            same = (times.tobytes(), log.command.tobytes(), *beside, *sorted(log.added.items()))
            groups.setdefault(same, []).append(k)
    found: dict[str, list[tuple[int, np.ndarray]]] = {}
    for members in groups.values():
        if len(members) < 2:
            continue
        for name in set.intersection(*(set(logs[k].outputs) for k in members)):
            runs = np.stack([logs[k].outputs[name] for k in members])
            read = np.isfinite(runs)
            if not (all_read := np.flatnonzero(read.all(axis=0))).size:
                continue
            if is_angle(name):
                runs = runs - runs[:, all_read[:1]]  # the angle at which a run begins is free
            several = read.sum(axis=0) > 1
            variance = np.full(len(several), np.nan)
            variance[several] = np.nanvar(runs[:, several], axis=0, ddof=1)
            for k in members:
                found.setdefault(name, []).append((k, variance))
    return found


def errors(problem: Problem, predictions: list[Prediction]) -> list[dict[str, np.ndarray]]:
    """Measured minus predicted.

    Args:
        problem: Logs and structure.
        predictions: Free runs of some of its logs.

    Returns:
        For every prediction the error `(time,)` [SI] of each logged output, NaN where a reading is missing.
    """
    return [
        {name: value - prediction.outputs[name] for name, value in problem.logs[prediction.log].outputs.items()}
        for prediction in predictions
    ]


def floor_variance(problem: Problem, predictions: list[Prediction]) -> list[dict[str, np.ndarray]]:
    """Squared floor; where runs repeat, their scatter if that is larger.

    Args:
        problem: Logs and structure.
        predictions: Free runs of some of its logs, with floor.

    Returns:
        For every prediction the variance `(time,)` [SI²] of each logged output.
    """
    variance = {p.log: {name: f**2 for name, f in p.floor.items()} for p in predictions}
    for name, members in repeatability(problem.logs).items():
        for k, scatter in members:
            mean = float(np.nanmean(scatter))
            if k in variance and mean > float(np.mean(variance[k][name])):
                variance[k][name] = np.where(np.isfinite(scatter), scatter, mean)
    return list(variance.values())
