"""Fit by the start rule: where a model is incomplete, a run takes its first state from its first 0.5 s. A fit that may
choose it bends it to hide what is missing, and then fails by the rule on which every gap is measured."""

from dataclasses import replace

import numpy as np

from rwjax.fit.coordinates import Coordinates
from rwjax.fit.end_to_end import Fit, fit
from rwjax.fit.problem import Problem
from rwjax.predict import errors, floor_variance, predict

COMPLETE = 4.0
"""Mean square in floors up to which a model counts as complete and first states stay free: time stamps that are off by
0.1 ms alone double it on a fast run, and a gap of three floors has 10."""


def _complete(begun: Fit) -> bool:
    """Whether a fit with free first states reaches the noise, and by the start rule the floor."""
    problem = begun.problem
    if 2.0 * begun.cost > COMPLETE * problem.batch.readings:
        return False
    predictions = predict(problem, begun.theta)
    square, floor = errors(problem, predictions), floor_variance(problem, predictions)
    fitted = np.flatnonzero(problem.batch.weight.any(axis=(1, 2, 3)))
    for name in problem.noise:
        logs = [k for k in fitted if name in square[k]]
        left = [np.nanmean(square[k][name] ** 2) for k in logs]
        if logs and np.mean(left) > COMPLETE * np.mean([np.mean(floor[k][name]) for k in logs]):
            return False
    return True


def fit_anchored(
    problem: Problem,
    coordinates: Coordinates,
    theta: np.ndarray,
    start: np.ndarray,
    *,
    damping: float = 1e-3,
    careful: bool = True,
) -> Fit:
    """Best fit in which first states and numbers agree: all free where the model reaches the noise, else the start
    rule's first states at the fitted numbers. `careful`: to the last digit and across the creases of stick and slip;
    otherwise as closely as a comparison of explanations needs.
    """
    most_steps, tolerance = (60, 1e-7) if careful else (20, 1e-4)
    begun = fit(
        problem,
        coordinates,
        theta,
        start=start,
        damping=damping,
        most_steps=most_steps,
        tolerance=tolerance,
        creases=careful,
    )
    if not problem.start_free.any() or _complete(begun):
        return begun
    return fit(
        replace(problem, anchored=problem.start_free.any(axis=1)),
        coordinates,
        begun.theta,
        start=begun.start,
        most_steps=most_steps,
        tolerance=tolerance,
        creases=careful,
    )
