"""Fit through a smooth solver: several starts, the width of the smooth sign shrunk in stages, initial states by the start rule.

A wide sign is easy to fit: the sum of squares has no ridges where a body would stick, and steps are few. Each stage begins where
the wider one ended, so that the last one, with the width that is wanted, begins near its optimum.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.gauss_newton import initial_state_normal, initial_state_response
from rwjax.fitting.initial_state import initial_states_by_sensitivities
from rwjax.fitting.initial_state_from_start import is_complete
from rwjax.fitting.multiple_shooting import Fit, reaches_noise
from rwjax.fitting.optimise import Unknowns, optimise
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import run_costs, sensitivities
from rwjax.simulation.shooting import Evaluation

STAGES = (16.0, 4.0, 1.0)
"""Widths of the smooth sign from stage to stage, in units of the one that is wanted [1]."""
COARSE, FINE = 0.1, 1e-3
"""Step below which a stage ends, and the last one, in units of the step that changes the readings by their noise [1]."""
ROUNDS = 6
"""Fits at most in which numbers and the initial states that they lead to come to agree."""
AGREE = 3e-3
"""Change of a number, in the same units, below which they do [1]."""


def fit_smooth(problem: Problem, coordinates: Coordinates, begin: Sequence[np.ndarray]) -> Fit:
    """Best fit through a smooth solver in which initial states and numbers agree.

    Initial states are free where the model is then complete; else they are taken from the start of each run.

    Args:
        problem: Logs and structure, with a `Smooth` solver of stated width.
        coordinates: The free numbers.
        begin: Parameter vectors `(t,)` [SI] where fits begin: the first one by itself, the others side by side and only where
            it does not reach the noise.

    Returns:
        The fit.
    """
    wide = _of_width(problem, STAGES[0])
    here = _best(wide, [_unknowns(wide, coordinates, begin[0], problem.start)], COARSE)
    if begin[1:] and not reaches_noise(here.cost, here.theta, problem):
        others = _best(wide, [_unknowns(wide, coordinates, theta, problem.start) for theta in begin[1:]], COARSE)
        here = min(here, others, key=lambda found: found.cost)
    for factor in STAGES[1:]:
        stage = _of_width(problem, factor)
        here = _best(
            stage, [_unknowns(stage, coordinates, here.theta, here.start)], FINE if factor == STAGES[-1] else COARSE
        )
    found = _fit(problem, coordinates, here)
    if not problem.start_free.any() or is_complete(found):
        return found
    return fit_from_starts(problem.from_start, found)


def fit_from_starts(problem: Problem, fitted: Fit) -> Fit:
    """Fit in which every initial state is the one that the first 0.5 s of its run lead to.

    Args:
        problem: Logs and structure, whose initial states are to be taken from the start.
        fitted: Where the fit begins.

    Returns:
        The fit.
    """
    c, here = fitted.coordinates, _Found(fitted.theta, fitted.start, fitted.cost, fitted.steps, True)
    for _ in range(ROUNDS):
        start = initial_states_by_sensitivities(problem, here.theta, here.start)
        unknowns = _unknowns(problem, c, here.theta, start)
        last, here = here.theta, _best(problem, [unknowns], FINE)._replace(start=start)
        if np.all(np.abs((here.theta - last)[c.index] / c.slope(last)) <= AGREE * unknowns.scale[: len(c.index)]):
            break
    start = initial_states_by_sensitivities(problem, here.theta, here.start)
    return _fit(problem, c, here._replace(start=start))


def _of_width(problem: Problem, factor: float) -> Problem:
    """The problem with a smooth sign so many times as wide."""
    return replace(problem, solver=replace(problem.solver, width=factor * problem.solver.width))


class _Found(NamedTuple):
    """A point of a fit: numbers `(t,)` and initial states `(l, n)` [SI], cost, iterations so far, whether the search settled."""

    theta: np.ndarray
    start: np.ndarray
    cost: float
    steps: int
    converged: bool


def _evaluated(problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray) -> tuple[float, Evaluation]:
    """Cost and derivatives of the free run at a point."""
    cost, nodes = run_costs(problem, theta, start)
    e = sensitivities(problem, theta, c.index, nodes)
    return float(np.sum(cost)) + problem.prior_cost(theta)[0], e


def _unknowns(problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray) -> Unknowns:
    """What a fit from a point may change; initial states that are taken from the start follow the numbers."""
    theta = c.clip(theta)
    _, e = _evaluated(problem, c, theta, start)
    k, (L, n) = np.arange(len(c.index)), start.shape
    p, slope = e.g.shape[1] - n, c.slope(theta)
    own = np.argwhere(problem.start_free)
    by_itself = ~problem.initial_state_from_start[own[:, 0]]
    response = np.zeros((L, n, len(k)))
    for log in np.flatnonzero(problem.initial_state_from_start):
        s = np.flatnonzero(problem.start_free[log])
        response[log, s] = initial_state_response(*initial_state_normal(problem, e, log), k, p + s, 0.0)[0]
    with np.errstate(all="ignore"):
        diagonal = np.diagonal(e.H, axis1=1, axis2=2)
        numbers = np.sum(diagonal[:, k], axis=0) * slope**2 + problem.precision[c.index] * slope**2
        states = diagonal[own[:, 0], p + own[:, 1]]
        size = np.sqrt(np.concatenate([numbers, states]) / max(problem.batch.readings, 1.0))
    moves = np.append(np.ones(len(k), bool), by_itself)
    return Unknowns(
        theta=theta,
        start=start,
        index=c.index,
        logarithmic=c.logarithmic,
        size=c.size,
        bounds=c.bounds,
        start_index=own,
        response=np.where(np.isfinite(response), response, 0.0),
        scale=np.where(moves & np.isfinite(size) & (size > 0.0), 1.0 / np.where(size > 0.0, size, 1.0), 0.0),
    )


def _best(problem: Problem, starts: Sequence[Unknowns], tolerance: float) -> _Found:
    """The best of several fits side by side."""
    every = Unknowns(*map(np.stack, zip(*starts, strict=True)))
    weight = np.tile(problem.batch.weight, (len(starts), 1, 1, 1, 1))
    prior = np.stack([problem.prior[:, 0], problem.precision], axis=1)
    found = optimise(
        problem.structure,
        every,
        weight,
        np.tile(prior, (len(starts), 1, 1)),
        np.array(tolerance),
        problem.batch,
        solver=problem.solver,
    )
    s = int(np.argmin(found.cost))
    return _Found(found.theta[s], found.start[s], float(found.cost[s]), int(found.steps[s]), bool(found.converged[s]))


def _fit(problem: Problem, c: Coordinates, found: _Found) -> Fit:
    """The fit at a point."""
    cost, e = _evaluated(problem, c, found.theta, found.start)
    return Fit(problem, c, found.theta, found.start, cost, e, found.converged, found.steps)
