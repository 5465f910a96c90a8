"""Block bootstrap of a fit: refits to stretches of the logs drawn with replacement.

Stretches, not samples, since residuals of a free run are correlated over seconds (Künsch, Annals of Statistics 17, 1989).
A stretch that is drawn twice weighs twice, one that is not drawn weighs nothing; the simulation stays that of whole runs.
What is known besides the logs is drawn anew, too, from its own distribution.
"""

from dataclasses import replace

import numpy as np

from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import Problem
from rwjax.fitting.threads import on_threads

STRETCHES = 24
"""Stretches into which all logs together are cut: enough to draw from, each long against the residual's memory."""


def _resampled(problem: Problem, rng: np.random.Generator) -> Problem:
    """The problem with every reading weighed by how often its stretch was drawn, and priors drawn."""
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
    spread = np.where(problem.prior[:, 1] > 0.0, np.maximum(problem.prior[:, 1], 1e-300) ** -0.5, 0.0)
    prior = np.stack([problem.prior[:, 0] + spread * rng.standard_normal(len(spread)), problem.prior[:, 1]], axis=1)
    return replace(problem, batch=problem.batch._replace(weight=weight), prior=prior)


def bootstrap(fitted: Fit, draws: int, seed: int = 0) -> np.ndarray:
    """Free numbers `(draws, k)` of refits to resampled stretches, each begun at the optimum."""
    rng = np.random.default_rng(seed)
    problems = [_resampled(fitted.problem, rng) for _ in range(draws)]

    def one(problem: Problem) -> np.ndarray:
        again = least_squares(
            problem, fitted.coordinates, fitted.theta, start=fitted.start, most_steps=15, tolerance=1e-5
        )
        return again.theta[fitted.coordinates.index]

    return np.array(on_threads(one, problems))
