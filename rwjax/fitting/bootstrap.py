"""Block bootstrap of a fit: refits to stretches of the logs drawn with replacement.

Stretches are drawn, not samples, because the residuals of a free run are correlated over seconds (Künsch, Annals of
Statistics 17, 1989). A stretch that is drawn twice weighs twice; one that is not drawn weighs nothing. Whole runs are
simulated all the same. What is known besides the logs is drawn anew from its own distribution.
"""

from dataclasses import replace

import numpy as np

from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import Problem
from rwjax.fitting.threads import on_threads

STRETCHES = 24
"""Stretches into which all logs together are cut: enough to draw from, each long against the residual's correlation."""


def _resampled(problem: Problem, rng: np.random.Generator) -> Problem:
    """The problem with every reading weighted by how often its stretch was drawn, and priors drawn."""
    lengths = np.array([log.time[-1] - log.time[0] for log in problem.logs])
    counted = problem.logs_with_readings
    length = lengths[counted].sum() / STRETCHES
    parts = np.zeros(len(lengths), int)
    parts[counted] = np.maximum(np.round(lengths[counted] / length), 1)
    times = rng.multinomial(parts.sum(), np.full(parts.sum(), 1.0 / parts.sum()))
    weight, first = problem.batch.weight.copy(), 0
    for k, log in enumerate(problem.logs):
        if not parts[k]:
            continue
        part = np.minimum((log.time - log.time[0]) / lengths[k] * parts[k], parts[k] - 1).astype(int)
        drawn = np.append(np.sqrt(times[first + part]), 0.0)  # empty slots point at the last entry
        weight[k] *= drawn[problem.batch.slot_sample[k]][..., None]
        first += parts[k]
    deviation = np.where(problem.prior[:, 1] > 0.0, np.maximum(problem.prior[:, 1], 1e-300) ** -0.5, 0.0)
    mean = problem.prior[:, 0] + deviation * rng.standard_normal(len(deviation))
    prior = np.stack([mean, problem.prior[:, 1]], axis=1)
    return replace(problem, batch=problem.batch._replace(weight=weight), prior=prior)


def bootstrap(fitted: Fit, draws: int, seed: int = 0) -> np.ndarray:
    """Free numbers of refits to resampled stretches, each of which begins at the optimum.

    Args:
        fitted: The fit.
        draws: How many refits [1].
        seed: Seed of the random numbers [1].

    Returns:
        Numbers `(draws, k)` [SI].
    """
    rng = np.random.default_rng(seed)
    problems = [_resampled(fitted.problem, rng) for _ in range(draws)]
    if fitted.problem.solver.smooth:
        from rwjax.fitting.smooth_fit import refits

        return refits(fitted, problems)

    def one(problem: Problem) -> np.ndarray:
        found = least_squares(
            problem, fitted.coordinates, fitted.theta, start=fitted.start, most_steps=15, tolerance=1e-5
        )
        return found.theta[fitted.coordinates.index]

    return np.array(on_threads(one, problems))
