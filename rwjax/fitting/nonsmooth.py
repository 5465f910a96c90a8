"""Least squares where stick-slip makes the cost nonsmooth.

The exact derivative at a point describes only its neighbourhood. Secants over a wider span show how the cost falls over
the whole valley.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rwjax.effects.library import dry_numbers, null_of_optional
from rwjax.fitting.batched_runs import Simulating, together
from rwjax.fitting.multiple_shooting import Fit, least_squares, reaches_noise
from rwjax.fitting.problem import Problem
from rwjax.fitting.secant import descend, residuals, search_point, slopes, step_by_slopes, with_residual
from rwjax.simulation.shooting import Evaluation

SPANS = (0.03, 0.01, 0.003)
"""Spans of the secants in coordinates: logarithms, or shares of the number's own size [1]."""
MOST_STEPS = 12
"""Secant steps at most."""
TOLERANCE = 1e-3
"""Share of the cost below which a step's gain leads to the next span, and up to which a number without trace stays where it is [1]."""
FAR, STAIRS, ROUNDS = 4.0, 113, 4
"""Factor up to which a number without trace is moved either way; how many values are tried within; and how often this is done, up to the root of
the factor where nothing better was found [1, 1, 1]."""
CARRIED_ON, STEPS_ELSEWHERE = 3, 2
"""Of the points found so, those from which a fit is tried anew; its steps, by which the other numbers settle roughly [1, 1]."""


def secant_steps(begun: Fit) -> Fit:
    """Gauss-Newton steps with secants over shrinking spans; only steps that lower the cost are kept.

    Args:
        begun: The point where the steps begin, with any derivatives.

    Returns:
        The best point, without derivatives. The unit of a linear coordinate is the number itself where that is larger than
        its typical size.
    """
    c = begun.coordinates
    wide = replace(c, size=np.maximum(c.size, np.abs(begun.theta[c.index])))

    def steps() -> Simulating[Fit]:
        here = yield from with_residual(replace(begun, coordinates=wide))
        return (yield from descend(here, most_steps=MOST_STEPS, tolerance=TOLERANCE, spans=SPANS))

    return together([steps()])[0]


def sticks(problem: Problem, theta: np.ndarray) -> bool:
    """Whether any dry friction acts: without it the sum of squares is smooth.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].

    Returns:
        True where a number that gives dry friction its level is positive.
    """
    own = [name.partition(" ")[0] for name in problem.names]  # "number in log" where each run has its own
    dry = dry_numbers(own)
    return any(name in dry and value > 0.0 for name, value in zip(own, theta, strict=True))


def leaves_no_trace(found: Fit) -> bool:
    """Whether a small change of some free number changes no reading, as that of a threshold between two commands that occur.

    Args:
        found: A fit with its derivatives.

    Returns:
        True where all derivatives by a number are 0.
    """
    return bool(_without_trace(found))


def _without_trace(found: Fit) -> list[int]:
    """Entries of `theta` of the free numbers all derivatives by which are 0."""
    index = found.coordinates.index
    return index[np.einsum("lkk->k", found.evaluation.H)[: len(index)] == 0.0].tolist()


def beyond_stairs(found: Fit, check: Callable[[], None] = lambda: None) -> Fit:
    """The best of a fit and of those that begin with a number without trace elsewhere.

    The cost is a staircase in such a number: no slope leads to another step of it, and the other numbers have settled on this one. Where
    one of an effect's form may as well have its null, it has. Any other one has the middle of its step, all of which leaves the same; where
    nothing tells it, it stays what it is.

    Args:
        found: A fit with its derivatives.
        check: Is called before every step; what it raises ends the fits.

    Returns:
        The best fit, with its derivatives.
    """
    problem, c, far = found.problem, found.coordinates, FAR
    for _ in range(ROUNDS):
        tried = [
            least_squares(problem, c, there.theta, start=there.start, most_steps=STEPS_ELSEWHERE, check=check)
            for k in _without_trace(found)
            if found.theta[k]
            for there in _on_other_stairs(found, k, far)
        ]
        best = min(tried, key=lambda f: f.cost, default=found)
        if found.cost - best.cost > TOLERANCE * max(best.cost, 1.0):  # else another step of its stairs is as good
            rest = least_squares(problem, c, best.theta, start=best.start, check=check)
            found = replace(rest, steps=rest.steps + best.steps + found.steps)
        else:
            far **= 0.5
    for k in _without_trace(found):
        if (null := null_of_optional(problem.names[k].partition(" ")[0])) is not None:
            at_null = least_squares(
                problem, c, _with(found.theta, k, null), start=found.start, most_steps=0, check=check
            )
            if at_null.cost <= found.cost:
                found = replace(at_null, converged=found.converged, steps=found.steps)
    for k in _without_trace(found):
        theta = _with(found.theta, k, _middle_of_its_step(found, k))
        there = least_squares(problem, c, theta, start=found.start, most_steps=0, check=check)
        found = replace(there, converged=found.converged, steps=found.steps)
    return found


def _elsewhere(found: Fit, k: int, far: float) -> Simulating[tuple[list[np.ndarray], np.ndarray]]:
    """Parameter vectors with a number up to a factor higher and lower, and their residuals, those of the fit itself in the middle."""
    factors = np.geomspace(1.0 / far, far, STAIRS)
    thetas = [found.coordinates.clip(_with(found.theta, k, factor * float(found.theta[k]))) for factor in factors]
    return thetas, (yield from residuals(found.problem, thetas, [found.start] * STAIRS))


def _on_other_stairs(found: Fit, k: int, far: float) -> list[Fit]:
    """Points with a number elsewhere, each on a step of its stairs of its own, from which a fit may go on: those that cost least.

    All other numbers and the initial states have taken one step, by their slopes at the fit.
    """
    problem, others = found.problem, found.coordinates.without(k)

    def runs() -> Simulating[tuple[Evaluation, list[np.ndarray], np.ndarray]]:
        thetas, r = yield from _elsewhere(found, k, far)
        e = yield from slopes(problem, others, found.theta, found.start, r[STAIRS // 2], SPANS[-1])
        return e, thetas, r

    e, thetas, r = together([runs()])[0]
    begins = [j for j in range(STAIRS) if j == 0 or not np.array_equal(r[j], r[j - 1])]
    middles = [(first + end - 1) // 2 for first, end in zip(begins, [*begins[1:], STAIRS], strict=True)]
    other = [j for j in middles if np.isfinite(r[j]).all() and not np.array_equal(r[j], r[STAIRS // 2])]
    there = [search_point(problem, others, thetas[j], found.start, r[j]) for j in other]
    return sorted(together([step_by_slopes(f, e) for f in there]), key=lambda f: f.cost)[:CARRIED_ON]


def _middle_of_its_step(found: Fit, k: int) -> float:
    """The number in the middle of the step of its stairs on which it is; itself where the step ends nowhere near."""
    thetas, r = together([_elsewhere(found, k, FAR ** (0.5**ROUNDS))])[0]
    differs = np.array([not np.array_equal(one, r[STAIRS // 2]) for one in r])
    below, above = np.flatnonzero(differs[: STAIRS // 2]), STAIRS // 2 + np.flatnonzero(differs[STAIRS // 2 :])
    if not len(below) or not len(above):
        return float(found.theta[k])
    return float(thetas[below[-1] + 1][k] + thetas[above[0] - 1][k]) / 2.0


def _with(theta: np.ndarray, k: int, value: float) -> np.ndarray:
    """A parameter vector with another number in one place."""
    return np.where(np.arange(len(theta)) == k, value, theta)


def past_ridges(found: Fit) -> Fit:
    """A fit, with secant steps after it where stick-slip, or a number without trace, may have stopped it well above the noise.

    Args:
        found: The fit at the end of `least_squares`.

    Returns:
        The better of both fits.
    """
    problem, c = found.problem, found.coordinates
    if (
        not len(c.index)
        or not np.isfinite(found.cost)
        or reaches_noise(found.cost, found.theta, problem)
        or not (sticks(problem, found.theta) or leaves_no_trace(found))
    ):
        return found
    better = secant_steps(found)
    rest = least_squares(problem, c, better.theta, start=better.start)
    return beyond_stairs(replace(rest, steps=rest.steps + found.steps) if rest.cost < found.cost else found)
