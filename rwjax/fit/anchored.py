"""Fit by the start rule: runs that start moving take their first state from their first 0.5 s, again and again."""

import numpy as np

from rwjax.fit.coordinates import Coordinates
from rwjax.fit.end_to_end import Fit, fit
from rwjax.fit.problem import Problem
from rwjax.predict import anchor

MOST_ROUNDS = 3
SETTLED = 1e-3
"""Relative change of the cost below which another round is not worth it."""


def fit_anchored(
    problem: Problem, coordinates: Coordinates, theta: np.ndarray, start: np.ndarray, *, creases: bool = True
) -> Fit:
    """Best fit in which first state and numbers agree: the first state is the start rule's at the fitted numbers.

    `start` serves for runs that start at rest, of which only the angle is free; `creases` as in `fit`.
    """
    anchored = anchor(problem, theta)
    resting = anchored.start_free.any(axis=1, keepdims=True)
    best: Fit | None = None
    for _ in range(MOST_ROUNDS):
        begin = np.where(resting, start, anchored.start)
        found = fit(anchored, coordinates, theta, start=begin, most_steps=60, creases=creases)
        if np.all(resting | ~problem.start_free.any(axis=1, keepdims=True)):
            return found
        theta, start = found.theta, found.start
        anchored = anchor(problem, theta)
        agreed = fit(anchored, coordinates, theta, start=np.where(resting, start, anchored.start), most_steps=0)
        settled = best is not None and abs(agreed.cost - best.cost) < SETTLED * best.cost
        if best is None or agreed.cost < best.cost:
            best = agreed
        if settled:
            break
    assert best is not None
    return best
