"""Fit through a smooth solver: several starts, the width of the smooth sign shrunk in stages, initial states by the start rule.

A wide sign leaves no ridges in the sum of squares where a body would stick. All starts are tried with the widest one; each further
stage begins where the best fit of the wider one ended.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rwjax.fitting.batched_runs import by_itself
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.gauss_newton import initial_state_normal, initial_state_response
from rwjax.fitting.initial_state import initial_states_by_rule
from rwjax.fitting.initial_state_from_start import is_complete
from rwjax.fitting.multiple_shooting import Fit, reaches_noise
from rwjax.fitting.optimise import Optimum, Unknowns, optimise
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import run_costs, sensitivities
from rwjax.simulation.shooting import Evaluation
from rwjax.simulation.smooth import Smooth

STAGES = (16.0, 4.0, 1.0)
"""Widths of the smooth sign from stage to stage, in units of the one that is wanted [1]."""
COARSE, FINE = 0.1, 3e-3
"""Step below which a stage ends, and the last one, in units of the step that changes the readings by their noise [1]."""
ROUNDS = 6
"""Searches of the last stage at most, each in units of its own beginning."""
TOGETHER = 8
"""Refits side by side: more of them wait longer for the slowest."""
LEAST_GAIN = 1e-5
"""Share of the cost below which what such a search gains, or loses by new initial states, ends the fit [1]."""


def fit_smooth(
    problem: Problem,
    coordinates: Coordinates,
    begin: Sequence[np.ndarray],
    progress: Callable[[str], None] = lambda text: None,
) -> Fit:
    """Best fit through a smooth solver in which initial states and numbers agree.

    Initial states are free where the model is then complete; else they are taken from the start of each run.

    Args:
        problem: Logs and structure, with a `Smooth` solver of stated width.
        coordinates: The free numbers.
        begin: Parameter vectors `(t,)` [SI] where fits begin: the first one by itself, the others side by side and only where
            it does not reach the noise.
        progress: Hears of every stage, in words.

    Returns:
        The fit.
    """
    progress(_stage_words(0, "; the first time it is compiled, which takes longest"))
    wide = _of_width(problem, STAGES[0])
    here = _best(wide, [_unknowns(wide, coordinates, begin[0], problem.start)], COARSE)
    if begin[1:] and not reaches_noise(here.cost, here.theta, problem):
        progress(_stage_words(0, f", from {len(begin) - 1} further starts"))
        others = _best(wide, [_unknowns(wide, coordinates, theta, problem.start) for theta in begin[1:]], COARSE)
        here = min(here, others, key=lambda found: found.cost)
    for k, factor in enumerate(STAGES[1:-1], start=1):
        progress(_stage_words(k))
        stage = _of_width(problem, factor)
        here = _best(stage, [_unknowns(stage, coordinates, here.theta, here.start)], COARSE)
    return _agreed(problem, coordinates, here, progress)


def _stage_words(k: int, more: str = "") -> str:
    """What a stage is, in words; the stages before it are `k`."""
    wide = (
        f"a sign of friction {STAGES[k]:g} times as wide as wanted" if STAGES[k] > 1.0 else "the width that is wanted"
    )
    return f"fitting by the smooth solver, stage {k + 1} of {len(STAGES)}: {wide}{more}"


def fit_again(problem: Problem, fitted: Fit) -> Fit:
    """Best fit of the last stage alone, from an earlier fit.

    Args:
        problem: Logs and structure, with other priors or weights than the fit's.
        fitted: The fit.

    Returns:
        The fit.
    """
    return _agreed(problem, fitted.coordinates, _Found(fitted.theta, fitted.start, fitted.cost, fitted.steps))


def _agreed(
    problem: Problem, c: Coordinates, here: "_Found", progress: Callable[[str], None] = lambda text: None
) -> Fit:
    """Fit of the last stage with free initial states, or with those of the start of each run if the model lacks something."""
    found = _settled(problem, c, here, progress)
    if not problem.start_free.any() or is_complete(found):
        return found
    return _settled(problem.from_start, c, _Found(found.theta, found.start, found.cost, found.steps), progress)


def _settled(problem: Problem, c: Coordinates, here: "_Found", progress: Callable[[str], None]) -> Fit:
    """Searches until one gains nothing; initial states that are taken from the start are estimated anew before each."""
    converged, steps = False, here.steps
    for k in range(ROUNDS):
        progress(_stage_words(len(STAGES) - 1, f", search {k + 1} of {ROUNDS} at most"))
        start = by_itself(initial_states_by_rule(problem, here.theta, here.start))
        before = _cost(problem, here.theta, start)
        here = _best(problem, [_unknowns(problem, c, here.theta, start)], FINE)
        steps += here.steps
        if converged := bool(before - here.cost <= LEAST_GAIN * before):
            break
    start = by_itself(initial_states_by_rule(problem, here.theta, here.start))
    cost, e = _evaluated(problem, c, here.theta, start)
    return Fit(problem, c, here.theta, start, cost, e, bool(converged and np.isfinite(cost)), steps)


def refits(fitted: Fit, problems: Sequence[Problem]) -> np.ndarray:
    """Free numbers of fits to the same logs with other weights and priors, several side by side, from the optimum.

    Args:
        fitted: The fit.
        problems: Its problem with other weights of the readings, and other priors.

    Returns:
        Numbers `(draws, k)` [SI].
    """
    start = _unknowns(fitted.problem, fitted.coordinates, fitted.theta, fitted.start)
    found = []
    for first in range(0, len(problems), TOGETHER):
        drawn = list(problems[first : first + TOGETHER])
        filled = drawn + drawn[-1:] * (TOGETHER - len(drawn))  # the last one again, so that one program serves
        theta = _searched(filled, [start] * TOGETHER, FINE).theta
        found.append(theta[: len(drawn), fitted.coordinates.index])
    return np.concatenate(found)


def _of_width(problem: Problem, factor: float) -> Problem:
    """The problem with a smooth sign so many times as wide."""
    solver = problem.solver
    assert isinstance(solver, Smooth) and solver.width is not None, "a width is chosen by `suited`"
    return replace(problem, solver=replace(solver, width=factor * solver.width))


class _Found(NamedTuple):
    """A point of a fit: numbers `(t,)` and initial states `(l, n)` [SI], cost, and the steps of the search that led there."""

    theta: np.ndarray
    start: np.ndarray
    cost: float
    steps: int


def _cost(problem: Problem, theta: np.ndarray, start: np.ndarray) -> float:
    """Cost of the free run at a point."""
    return float(np.sum(run_costs(problem, theta, start)[0])) + problem.prior_cost(theta)[0]


def _evaluated(problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray) -> tuple[float, Evaluation]:
    """Cost and derivatives of the free run at a point."""
    cost, nodes = run_costs(problem, theta, start)
    return float(np.sum(cost)) + problem.prior_cost(theta)[0], sensitivities(problem, theta, c.index, nodes)


def _unknowns(problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray) -> Unknowns:
    """What a fit from a point may change; initial states that are taken from the start follow the numbers."""
    theta = c.clip(theta)
    _, e = _evaluated(problem, c, theta, start)
    k, (L, n) = np.arange(len(c.index)), start.shape
    p, slope = e.g.shape[1] - n, c.slope(theta)
    own = np.argwhere(problem.start_free)
    by_itself = ~problem.initial_state_from_start[own[:, 0]]
    response = np.zeros((L, n, len(k)))
    for log in map(int, np.flatnonzero(problem.initial_state_from_start)):
        s = np.flatnonzero(problem.start_free[log])
        response[log, s] = initial_state_response(*initial_state_normal(problem, e, log), k, p + s, 0.0)[0]
    with np.errstate(all="ignore"):
        diagonal = np.diagonal(e.H, axis1=1, axis2=2)
        numbers = np.sum(diagonal[:, k], axis=0) * slope**2 + problem.precision[c.index] * slope**2
        states = diagonal[own[:, 0], p + own[:, 1]]
        size = np.sqrt(np.concatenate([numbers, states]) / max(problem.batch.readings, 1.0))
    low, high = c.on_bound(theta)
    downhill = -(np.sum(e.g[:, k], axis=0) + problem.prior_cost(theta)[1][c.index]) * slope
    leaves = (low & (downhill < 0.0)) | (high & (downhill > 0.0))  # a number that would leave through its bound is held
    moves = np.append(~leaves, by_itself)
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
    """The best of several searches side by side."""
    found = _searched([problem] * len(starts), starts, tolerance)
    s = int(np.argmin(found.cost))
    return _Found(found.theta[s], found.start[s], float(found.cost[s]), int(found.steps[s]))


def _searched(problems: Sequence[Problem], starts: Sequence[Unknowns], tolerance: float) -> Optimum:
    """Where searches side by side end; the problems differ in weights and priors alone."""
    every = Unknowns(*map(np.stack, zip(*starts, strict=True)))
    weight = np.stack([problem.batch.weight for problem in problems])
    prior = np.stack([np.stack([problem.prior[:, 0], problem.precision], axis=1) for problem in problems])
    one = problems[0]
    return optimise(one.structure, every, weight, prior, np.array(tolerance), one.batch, solver=one.solver)
