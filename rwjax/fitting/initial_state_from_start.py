"""Whether initial states may be free in a fit, or follow from the first 0.5 s of each run.

A fit that may choose the initial states of an incomplete model bends them to hide what is missing. The model then
misses the readings by the gap's rule, which takes every run's initial state from its start.
"""

import numpy as np

from rwjax.fitting.gauss_newton import initial_state_normal, initial_state_response
from rwjax.fitting.initial_state import initial_state_covariance
from rwjax.fitting.multiple_shooting import Fit, carried_on, least_squares
from rwjax.fitting.nonsmooth import past_ridges
from rwjax.fitting.sensitivities import residual_jacobian

COMPLETE = 4.0
"""Mean square in units of the floor up to which a model counts as complete [1].

Time stamps that are off by 0.1 ms double it on a fast run; a gap of three floors has 10.
"""
UNLUCKY = 10.8
"""Square of an initial state's error, in its variances, that a complete model may have [1].

Chance exceeds it once in a thousand.
"""


def is_complete(fitted: Fit) -> bool:
    """Whether a fit with free initial states reaches the noise, and with initial states from the start the floor.

    The sensitivities at the optimum give those initial states and their floor. Near it the model is almost linear in
    them, and nothing has to be simulated again.

    Args:
        fitted: The fit, with its derivatives.

    Returns:
        True where the model lacks nothing that these logs show.
    """
    problem, e = fitted.problem, fitted.evaluation
    if 2.0 * (fitted.cost - problem.prior_cost(fitted.theta)[0]) > COMPLETE * problem.batch.readings:
        return False
    from_start = problem.from_start
    n, nothing = problem.start.shape[1], np.zeros(0, int)
    p = len(e.local) - n
    states = np.eye(len(e.local))[:, p:]
    square, limit = np.zeros((2, len(problem.structure.outputs)))
    for log in map(int, problem.logs_with_readings):
        s = np.flatnonzero(problem.start_free[log])
        change = initial_state_response(*initial_state_normal(from_start, e, log), nothing, p + s, 0.0)[1]
        through = residual_jacobian(e, log, states)
        covariance = initial_state_covariance(problem, through, log)
        for y in np.flatnonzero(problem.batch.weight[log].any(axis=(0, 1))):
            seen = problem.batch.weight[log, ..., y] > 0.0
            by_state = through[..., y, :][seen]
            scatter = np.sum(by_state @ covariance * by_state, axis=1)
            square[y] += np.sum((e.residual[log, ..., y][seen] + by_state[:, s] @ change) ** 2)
            limit[y] += np.sum(COMPLETE * problem.batch.share[log, ..., y][seen] + UNLUCKY * np.maximum(scatter, 0.0))
    return bool(np.all(square <= limit))


def fit_from_start(begun: Fit) -> Fit:
    """Best fit in which initial states and numbers agree.

    Initial states are free where the model is then complete; else they are taken from the start of each run.

    Args:
        begun: The fit that is carried to its end, with its derivatives.

    Returns:
        The fit.
    """
    found = past_ridges(carried_on(begun))
    if not begun.problem.start_free.any() or is_complete(found):
        return found
    return past_ridges(least_squares(begun.problem.from_start, begun.coordinates, found.theta, start=found.start))
