"""Uninformative logs: when logs that the rig explains say nothing of it."""

from collections.abc import Mapping, Sequence

import numpy as np

from rwjax.diagnosis.settings import RemarkSettings
from rwjax.fitting.multiple_shooting import Fit
from rwjax.logs.log import Log
from rwjax.logs.noise import noise_by_output
from rwjax.rig.model import Rig


def moves(log: Log, limits: RemarkSettings) -> bool:
    """Whether any reading of a log changes by more than its noise.

    Args:
        log: the log.
        limits: what counts as a change.

    Returns:
        True where a running mean of some output leaves the range that noise gives it.
    """
    noise, averaged = noise_by_output(log), limits.averaged
    for name, value in log.outputs.items():
        seen = value[np.isfinite(value)]
        mean = np.convolve(seen, np.full(averaged, 1.0 / averaged), "valid") if len(seen) >= averaged else seen
        if len(seen) and np.ptp(mean) > limits.moves * noise[name]:
            return True
    return False


def diverged_numbers(rig: Rig, fitted: Fit, limits: RemarkSettings) -> tuple[str, ...]:
    """Free numbers of the rig that left their size altogether.

    What holds a part at rest looks like a number without end.

    Args:
        rig: the rig as it is.
        fitted: its fit.
        limits: how far a number may go.

    Returns:
        The names of the numbers.
    """
    value = fitted.numbers()
    return tuple(name for name in rig.free if 0.0 < rig.values.get(name, 0.0) * limits.diverged < value[name])


def stands_still(fitted: Fit, limits: RemarkSettings) -> bool:
    """Whether some output hardly moves in a fitted rig, by less than its noise in every run.

    Args:
        fitted: the fit.
        limits: which of its readings count.

    Returns:
        True where one does.
    """
    problem = fitted.problem
    y, _ = problem.free_run(fitted.theta, fitted.start)
    seen = problem.batch.weight > 0.0
    for k, name in enumerate(problem.structure.outputs):
        runs = [run[of_run] for run, of_run in zip(y[..., k], seen[..., k], strict=True) if of_run.any()]
        moved = [np.ptp(np.quantile(run, (limits.outermost, 1.0 - limits.outermost))) for run in runs]
        if moved and max(moved) < problem.noise[name]:
            return True
    return False


def why_uninformative(logs: Sequence[Log], diverged: tuple[str, ...], limits: RemarkSettings) -> str | None:
    """Why logs that a rig explains say nothing of it.

    Args:
        logs: all logs.
        diverged: the rig's numbers that diverged in its fit.
        limits: what counts as a motion.

    Returns:
        The reason as a clause, None where the logs do say something.
    """
    if not any(moves(log, limits) for log in logs):
        return "nothing moves in these logs"
    return f"{part_of(diverged)} hardly moves in these logs" if diverged else None


DROWNED = "the first states of the held-out runs are so uncertain that a perfect model could miss these by more than they move"
"""Why runs say nothing whose floors are larger than their motion."""


def drowned(floors: Mapping[str, float], readings: Mapping[str, Sequence[np.ndarray]]) -> bool:
    """Whether the floor of every output is larger than its motion.

    Args:
        floors: floor of every output [SI].
        readings: readings (time,) of every output in each held-out run [SI].

    Returns:
        True where no output moves by more than a perfect model may leave.
    """
    read = {name: [x[np.isfinite(x)] for x in runs if np.isfinite(x).any()] for name, runs in readings.items()}
    motion = {name: np.concatenate([x - np.mean(x) for x in runs]) for name, runs in read.items() if runs}
    return all(floors[name] > np.sqrt(np.mean(m**2)) for name, m in motion.items())


def part_of(numbers: tuple[str, ...]) -> str:
    """The part of a rig that some of its numbers belong to.

    Args:
        numbers: names of numbers of the rig file.

    Returns:
        The part in words, the rig where there are no numbers.
    """
    return f"what {', '.join(numbers)} belongs to" if numbers else "the rig"
