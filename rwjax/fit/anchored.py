"""Fit by the start rule: where a model is incomplete, a run takes its first state from its first 0.5 s. A fit that may choose it bends it to hide what is missing, and then fails by the rule on which every gap is
measured."""

from dataclasses import replace

import numpy as np

from rwjax.fit.coordinates import Coordinates
from rwjax.fit.end_to_end import Fit, fit
from rwjax.fit.problem import Problem

COMPLETE = 2.0
"""Mean square in units of noise up to which a model counts as complete and first states stay free."""


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
    if not problem.start_free.any() or 2.0 * begun.cost <= COMPLETE * problem.batch.readings:
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
