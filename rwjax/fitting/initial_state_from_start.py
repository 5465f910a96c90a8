"""Fit by the start rule: where a model is incomplete, a run takes its first state from its first 0.5 s. A fit that may
choose it bends it to hide what is missing, and then fails by the rule on which every gap is measured."""

import numpy as np

from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.gauss_newton import initial_state_normal, initial_state_response
from rwjax.fitting.initial_state import initial_state_covariance
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import residual_jacobian

COMPLETE = 4.0
"""Mean square in floors up to which a model counts as complete and first states stay free: time stamps that are off by
0.1 ms alone double it on a fast run, and a gap of three floors has 10."""


UNLUCKY = 10.8
"""Square of a start's error, in its variances, that a complete model may have: chance exceeds it once in a thousand."""


def is_complete(begun: Fit) -> bool:
    """Whether a fit with free first states reaches the noise, and by the start rule the floor.

    The start rule's first states and their floor are those that the sensitivities at the optimum give: near it the
    model is as good as linear in them, and nothing has to be simulated again.
    """
    problem, e = begun.problem, begun.evaluation
    if 2.0 * (begun.cost - problem.prior_cost(begun.theta)[0]) > COMPLETE * problem.batch.readings:
        return False
    rule = problem.from_start
    n, nothing = problem.start.shape[1], np.zeros(0, int)
    p = len(e.local) - n
    square, limit = np.zeros((2, len(problem.structure.outputs)))
    for log in map(int, problem.logs_with_readings):
        s = np.flatnonzero(problem.start_free[log])
        change = initial_state_response(*initial_state_normal(rule, e, log), nothing, p + s, 0.0)[1]
        through = residual_jacobian(e, log)[..., p:]
        seen = problem.batch.weight[log] > 0.0
        scatter = np.einsum("wqya,ab,wqyb->wqy", through, initial_state_covariance(problem, through, log), through)
        square += np.sum(np.where(seen, e.residual[log] + through[..., s] @ change, 0.0) ** 2, axis=(0, 1))
        allowed = COMPLETE * problem.batch.share[log] + UNLUCKY * np.maximum(scatter, 0.0)
        limit += np.sum(np.where(seen, allowed, 0.0), axis=(0, 1))
    return bool(np.all(square <= limit))


def fit_from_start(
    problem: Problem,
    coordinates: Coordinates,
    theta: np.ndarray,
    start: np.ndarray,
) -> Fit:
    """Best fit in which first states and numbers agree: all free where the model reaches the noise, else the start
    rule's first states at the fitted numbers."""
    begun = least_squares(problem, coordinates, theta, start=start, creases=True)
    if not problem.start_free.any() or is_complete(begun):
        return begun
    return least_squares(problem.from_start, coordinates, begun.theta, start=begun.start, creases=True)
