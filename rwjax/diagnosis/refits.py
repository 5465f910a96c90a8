"""Refits: numbers of hypotheses on some of the training logs, which a run that was left out is judged by."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.fitting.batched_runs import Simulating
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.gauss_newton import steps_without
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import Problem
from rwjax.fitting.processes import Task
from rwjax.fitting.secant import descend, search_point, with_residual


def refitted(fits: ModelFits, cases: Sequence[tuple[Hypothesis, Sequence[int]]]) -> list[np.ndarray]:
    """Numbers of hypotheses fitted to some of the training logs, from their estimates on all of them.

    Where the logs left out tell little of the numbers, the first step says how far these move. That takes no free run.

    Args:
        fits: fits to the training logs.
        cases: each the rig as it is or a hypothesis with a fit that a search has begun, and numbers of some of the training logs.

    Returns:
        The parameter vectors `(t,)` [SI].
    """
    elsewhere: dict[Hypothesis, list[int]] = {}
    for number, (hypothesis, train) in enumerate(cases):
        if {*train} != {*fits.train}:
            elsewhere.setdefault(hypothesis, []).append(number)
    found = [fits(hypothesis).theta for hypothesis, _ in cases]
    wanted: list[int] = []
    for hypothesis, numbers in elsewhere.items():
        without = [[k for k in fits.train if k not in cases[number][1]] for number in numbers]
        moved = _without(fits(hypothesis), without, fits.settings.fitting.light_run)
        for number, theta in zip(numbers, moved, strict=True):
            if theta is None:
                wanted.append(number)
            else:
                found[number] = theta
    for number, theta in zip(wanted, fits.together([_refit(fits, *cases[k]) for k in wanted]), strict=True):
        found[number] = theta
    return found


def _refit(fits: ModelFits, hypothesis: Hypothesis, train: Sequence[int]) -> Task[np.ndarray]:
    """Numbers of a hypothesis by a fit to some logs."""
    begun, problem, limits = fits(hypothesis), fits.problem_of(hypothesis), fits.settings.fitting
    begin = (problem, begun.coordinates, begun.theta, begun.start, train, fits.by_start_rule)
    return Task(problem, partial(_refitted, *begin, limits.fold_steps, limits.tolerance))


def _refitted(
    problem: Problem,
    coordinates: Coordinates,
    theta: np.ndarray,
    start: np.ndarray,
    train: Sequence[int],
    by_start_rule: bool,
    steps: int,
    tolerance: float,
) -> Simulating[np.ndarray]:
    """Numbers of a fit to some logs alone."""
    alone = problem.only(train)
    start = np.where(alone.start_free, start, alone.start)
    begun = search_point(alone.from_start if by_start_rule else alone, coordinates, theta, start)
    here = yield from with_residual(begun)
    return (yield from descend(here, most_steps=steps, tolerance=tolerance)).theta


def _without(fitted: Fit, left_out: Sequence[Sequence[int]], most: float) -> list[np.ndarray | None]:
    """Numbers of a fit without some of its logs, each time others, to first order; None where that is not enough."""
    c, theta, moved = fitted.coordinates, fitted.theta, list[np.ndarray | None]()
    for dz in steps_without(fitted.problem, fitted.evaluation, c, theta, left_out, most):
        there = theta if dz is None else c.move(theta, dz)
        stays = all(map(np.array_equal, c.on_bound(there), c.on_bound(theta)))  # within its bounds
        moved.append(there if dz is not None and stays and c.shorten(dz) == 1.0 else None)
    return moved
