"""Free run of a model against logs: the start rule, the prediction, its floor and the gap.

The start is least squares of the model's own initial states over the first 0.5 s; nothing after it is looked at. A run
that begins with input and rates indistinguishable from zero starts at rest. The floor is what a perfect model would
still leave: noise and quantisation of the readings, the start's uncertainty carried through the model, and the scatter
of runs that repeat one command.
"""

from dataclasses import dataclass

import numpy as np

from rwjax.build import structure_of, theta_of
from rwjax.fit.end_to_end import first_states, sensitivities
from rwjax.fit.problem import START_S, Problem, pose, starts_at_rest
from rwjax.grid import by_sample
from rwjax.log import Log
from rwjax.rig import Rig
from rwjax.simulate import free_run


@dataclass(frozen=True)
class Prediction:
    """Free run of one log. `outputs`: predicted readings in SI at the log's times, by name, all that the kind has.

    `floor`: standard deviation of what a perfect model would still leave, for each logged output, `(time,)`.
    """

    outputs: dict[str, np.ndarray]
    start: np.ndarray
    floor: dict[str, np.ndarray]


def start_covariance(problem: Problem, local: np.ndarray, chain: np.ndarray, log: int) -> np.ndarray:
    """Covariance of a log's first state from the readings of the first 0.5 s `(n, n)`."""
    s = np.flatnonzero(problem.start_free[log])
    n = problem.start.shape[1]
    covariance = np.zeros((n, n))
    if not len(s):
        return covariance
    record, names = problem.logs[log], problem.structure.outputs
    by_start = np.einsum("nwqy,wnk->wqyk", local[-n:, log], chain[log][:, :, -n:])
    G = by_sample(problem.batch, log, by_start, len(record.time))
    first = record.time - record.time[0] <= START_S
    H = np.zeros((n, n))
    for y, name in enumerate(names):
        if name in record.outputs:
            H += G[first, y].T @ G[first, y]
    H = H[np.ix_(s, s)]
    scale = np.sqrt(np.maximum(np.diag(H), 1e-300))
    covariance[np.ix_(s, s)] = (
        np.linalg.pinv(H / scale / scale[:, None], rcond=1e-10, hermitian=True) / scale / scale[:, None]
    )
    return covariance


def predict(problem: Problem, theta: np.ndarray, *, with_floor: bool = True) -> list[Prediction]:
    """Free runs of all logs of a problem from the start rule, with the floor if wanted."""
    start = first_states(problem, theta)
    y, nodes = (np.asarray(a) for a in free_run(problem.structure, theta, start, problem.batch))
    names = problem.structure.outputs
    n = problem.start.shape[1]
    if with_floor:
        e = sensitivities(problem, theta, np.zeros(0, int), nodes)
        local, chain = e.local, e.chain
    found = []
    for k, log in enumerate(problem.logs):
        samples = by_sample(problem.batch, k, y[k], len(log.time))
        floor = {}
        if with_floor:
            P0 = start_covariance(problem, local, chain, k)
            S = by_sample(
                problem.batch, k, np.einsum("nwqy,wnk->wqyk", local[-n:, k], chain[k][:, :, -n:]), len(log.time)
            )
            for j, name in enumerate(names):
                if name in log.outputs:
                    from_start = np.einsum("ta,ab,tb->t", S[:, j], P0, S[:, j])
                    floor[name] = problem.noise[name] * np.sqrt(1.0 + np.maximum(from_start, 0.0))
        found.append(Prediction({name: samples[:, j] for j, name in enumerate(names)}, start[k], floor))
    return found


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
            if name in ("yaw_rad", "wheel_rad"):
                runs = runs - runs[:, :1]  # the angle at which a run begins is free
            variance = np.nanvar(runs, axis=0, ddof=1)
            for k in members:
                found.setdefault(name, []).append((k, variance))
    return found


def errors(problem: Problem, predictions: list[Prediction]) -> list[dict[str, np.ndarray]]:
    """Measured minus predicted for every log and logged output, NaN where a reading is missing."""
    return [
        {name: value - prediction.outputs[name] for name, value in log.outputs.items()}
        for log, prediction in zip(problem.logs, predictions, strict=True)
    ]


def floor_variance(problem: Problem, predictions: list[Prediction]) -> list[dict[str, np.ndarray]]:
    """Squared floor for every log and output at its times; where runs repeat, their scatter if that is larger."""
    variance = [{name: f**2 for name, f in prediction.floor.items()} for prediction in predictions]
    for name, members in repeatability(problem.logs).items():
        for k, scatter in members:
            mean = float(np.nanmean(scatter))
            if mean > float(np.mean(variance[k][name])):
                variance[k][name] = np.where(np.isfinite(scatter), scatter, mean)
    return variance


def predict_log(rig: Rig, log: Log) -> dict[str, np.ndarray]:
    """Columns of `rwjax predict`: `time_s` and the free run of each measured output in SI at the log's times.

    A log without outputs starts at rest at 0 and gets every output that the kind of rig has.
    """
    structure = structure_of(rig)
    problem = pose(structure, (log,))
    outputs = predict(problem, theta_of(rig, structure), with_floor=False)[0].outputs
    wanted = [name for name in structure.outputs if not log.outputs or name in log.outputs]
    return {"time_s": log.time, **{name: outputs[name] for name in wanted}}
