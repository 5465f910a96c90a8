"""Free run of a model against logs: the start rule, the prediction, its floor and the gap.

The start is least squares of the model's own initial states over the first 0.5 s; nothing after it is looked at. A run
that begins with input and rates indistinguishable from zero starts at rest. The floor is what a perfect model would
still leave: noise and quantisation of the readings, the start's uncertainty carried through the model, and the scatter
of runs that repeat one command.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.fitting.batched_runs import Simulating, Wanted, together
from rwjax.fitting.initial_guess import starts_at_rest
from rwjax.fitting.initial_state import initial_state_covariance
from rwjax.fitting.initial_state_by_secants import initial_states_by_secants, moved_starts
from rwjax.fitting.problem import Problem
from rwjax.kinds import is_angle
from rwjax.simulation.batch import by_sample


@dataclass(frozen=True)
class Prediction:
    """Free run of the log numbered `log`. `outputs`: predicted readings in SI at the log's times, by name, all that the kind has.

    `floor`: standard deviation of what a perfect model would still leave, for each logged output, `(time,)`.
    """

    log: int
    outputs: dict[str, np.ndarray]
    start: np.ndarray
    floor: dict[str, np.ndarray]


def predict_logs(problem: Problem, theta: np.ndarray, *, with_floor: bool = True) -> list[Prediction]:
    """Free runs of all logs of a problem from the start rule, with the floor if wanted."""
    return together([predicted(problem, theta, range(len(problem.logs)), with_floor=with_floor)])[0]


def predicted(
    problem: Problem, theta: np.ndarray, logs: Sequence[int], *, with_floor: bool
) -> Simulating[list[Prediction]]:
    """`predict_logs` of some logs, beside other searches."""
    start, y, by_state = yield from _from_start_rule(problem, theta, np.array(logs), with_floor)
    names = problem.structure.outputs
    found = []
    for k, readings, slopes in zip(logs, y, np.moveaxis(by_state, 1, 0), strict=True):
        log = problem.logs[k]
        samples = by_sample(problem.batch, k, readings, len(log.time))
        floor = {}
        if with_floor:
            through = np.moveaxis(slopes, 0, -1) * problem.batch.weight[k][..., None]
            P0 = initial_state_covariance(problem, through, k)
            S = by_sample(problem.batch, k, through, len(log.time))
            for j, name in enumerate(names):
                if name in log.outputs:
                    from_start = np.einsum("ta,ab,tb->t", S[:, j], P0, S[:, j])
                    floor[name] = problem.noise[name] * np.sqrt(1.0 + np.maximum(from_start, 0.0))
        found.append(Prediction(k, {name: samples[:, j] for j, name in enumerate(names)}, start[k], floor))
    return found


def _from_start_rule(
    problem: Problem, theta: np.ndarray, logs: np.ndarray, with_secants: bool
) -> Simulating[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """First states of all logs by the start rule; of the wanted ones readings `(l, w, q, y)` and their secants by the first
    states `(n, l, …)`, 0 where they are not asked for or a run leaves the range of numbers."""
    start = yield from initial_states_by_secants(problem, theta)
    states, width, moved = moved_starts(problem, start) if with_secants else (np.zeros(0, int), start, [])
    windows = problem.batch.windows
    y = yield Wanted(problem, np.tile(theta, (1 + len(states), 1)), np.stack([start, *moved]), logs, windows)
    by_state = np.zeros((start.shape[1], *y.shape[1:]))
    with np.errstate(over="ignore", invalid="ignore"):
        change = (y[1:] - y[0]) / width[logs].T[states][..., None, None, None]
    by_state[states] = np.where(np.isfinite(change).all(axis=(1, 2, 3, 4), keepdims=True), change, 0.0)
    return start, y[0], by_state


def repeatability(logs: tuple) -> dict[str, list[tuple[int, np.ndarray]]]:
    """Scatter between runs of one command, all from rest: for each output, (log, variance at its times)."""
    groups: dict[tuple, list[int]] = {}
    for k, log in enumerate(logs):
        if starts_at_rest(log):  # a run that starts moving repeats only what moved alike
            times = np.round(log.time - log.time[0], 3)
            groups.setdefault((times.tobytes(), log.command.tobytes()), []).append(k)
    found: dict[str, list[tuple[int, np.ndarray]]] = {}
    for members in groups.values():
        if len(members) < 2:
            continue
        for name in set.intersection(*(set(logs[k].outputs) for k in members)):
            runs = np.stack([logs[k].outputs[name] for k in members])
            if is_angle(name):
                runs = runs - runs[:, :1]  # the angle at which a run begins is free
            variance = np.nanvar(runs, axis=0, ddof=1)
            for k in members:
                found.setdefault(name, []).append((k, variance))
    return found


def errors(problem: Problem, predictions: list[Prediction]) -> list[dict[str, np.ndarray]]:
    """Measured minus predicted for every prediction and logged output, NaN where a reading is missing."""
    return [
        {name: value - prediction.outputs[name] for name, value in problem.logs[prediction.log].outputs.items()}
        for prediction in predictions
    ]


def floor_variance(problem: Problem, predictions: list[Prediction]) -> list[dict[str, np.ndarray]]:
    """Squared floor for every prediction and output at its times; where runs repeat, their scatter if that is larger."""
    variance = {p.log: {name: f**2 for name, f in p.floor.items()} for p in predictions}
    for name, members in repeatability(problem.logs).items():
        for k, scatter in members:
            mean = float(np.nanmean(scatter))
            if k in variance and mean > float(np.mean(variance[k][name])):
                variance[k][name] = np.where(np.isfinite(scatter), scatter, mean)
    return list(variance.values())
