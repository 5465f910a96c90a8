"""Fit by the start rule: where a model is incomplete, a run that starts moving takes its first state from its first
0.5 s, not from whatever hides the misfit of the rest."""

import numpy as np

from rwjax.fit.coordinates import Coordinates
from rwjax.fit.end_to_end import Fit, fit
from rwjax.fit.problem import Problem
from rwjax.predict import anchor

MOST_ROUNDS = 3
SETTLED = 1e-3
"""Relative change of the cost below which another round is not worth it."""
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
    """Best fit in which first states and numbers agree: all free where the model reaches the noise or every run starts
    at rest, else the start rule's first states at the fitted numbers. `careful`: to the last digit and across the
    creases of stick and slip; otherwise as closely as a comparison of explanations needs.
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
    moving = problem.moving[:, None]
    if not moving.any() or 2.0 * begun.cost <= COMPLETE * problem.batch.readings:
        return begun
    anchored = anchor(problem, begun.theta)
    theta, best = begun.theta, begun
    for k in range(MOST_ROUNDS if careful else 1):
        first = np.where(moving, anchored.start, begun.start)
        found = fit(
            anchored, coordinates, theta, start=first, most_steps=most_steps, tolerance=tolerance, creases=careful
        )
        theta = found.theta
        anchored = anchor(problem, theta)
        agreed = fit(anchored, coordinates, theta, start=np.where(moving, anchored.start, found.start), most_steps=0)
        settled = k > 0 and abs(agreed.cost - best.cost) < SETTLED * best.cost
        if k == 0 or agreed.cost < best.cost:
            best = agreed
        if settled:
            break
    return best
