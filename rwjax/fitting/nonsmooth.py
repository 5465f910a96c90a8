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
REACH, VALUES, ROUNDS = 4.0, 113, 4
"""Factor up to which a number without trace is moved either way; how many values are tried within; and how often this is done, up to the root of
the factor where nothing better was found [1, 1, 1]."""
CARRIED_ON, STEPS_ELSEWHERE = 3, 2
"""Of the points found so, those from which a fit is tried anew; its steps, by which the other numbers settle roughly [1, 1]."""
NARROWER = (1 / 16, 1 / 4, 1)
"""Powers of the factor within which the ends of a number's step are looked for, one after the other [1]."""
AT_A_TIME = 16
"""Runs whose readings are held at a time."""


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
    both ends of the step are not near, it stays what it is.

    Args:
        found: A fit with its derivatives.
        check: Is called before every step; what it raises ends the fits.

    Returns:
        The best fit, with its derivatives.
    """
    problem, c, reach = found.problem, found.coordinates, REACH
    for _ in range(ROUNDS):
        tried = [
            least_squares(problem, c, there.theta, start=there.start, most_steps=STEPS_ELSEWHERE, check=check)
            for k in _without_trace(found)
            if found.theta[k]
            for there in _on_other_steps(found, k, reach, check)
        ]
        if not tried:
            break
        best = min(tried, key=lambda f: f.cost)
        if found.cost - best.cost > TOLERANCE * max(best.cost, 1.0):  # else another step of its stairs is as good
            rest = least_squares(problem, c, best.theta, start=best.start, check=check)
            found = replace(rest, steps=rest.steps + best.steps + found.steps)
        else:
            reach **= 0.5
    for k in _without_trace(found):
        null = null_of_optional(problem.names[k].partition(" ")[0])
        for value in (null, _middle_of_its_step(found, k, check)):
            if value is not None and found.theta[k] not in (value, null):
                theta = _with(found.theta, k, value)
                there = least_squares(problem, c, theta, start=found.start, most_steps=0, check=check)
                if there.cost <= found.cost:
                    found = replace(there, converged=found.converged, steps=found.steps)
    return found


def _swept(found: Fit, k: int, reach: float, check: Callable[[], None]) -> tuple[list[np.ndarray], np.ndarray]:
    """Parameter vectors with a number up to a factor higher and lower, the fit's own in the middle, and their squares left.

    On one step of its stairs the squares are the same to the last bit.
    """
    factors, squares = np.geomspace(1.0 / reach, reach, VALUES), list[float]()
    thetas = [found.coordinates.clip(_with(found.theta, k, factor * float(found.theta[k]))) for factor in factors]
    for first in range(0, VALUES, AT_A_TIME):
        check()
        group = thetas[first : first + AT_A_TIME]
        (r,) = together([residuals(found.problem, group, [found.start] * len(group))])
        squares += [float(np.vdot(one, one)) for one in r]
    return thetas, np.array(squares)


def _on_other_steps(found: Fit, k: int, reach: float, check: Callable[[], None]) -> list[Fit]:
    """Points with a number on other steps of its stairs, from which a fit may go on: those that cost least.

    All other numbers and the initial states have taken one step, by their slopes at the fit.
    """
    problem, others = found.problem, found.coordinates.without(k)
    thetas, squares = _swept(found, k, reach, check)
    firsts = [0, *(1 + np.flatnonzero(np.diff(squares)))]
    middles = [(first + end - 1) // 2 for first, end in zip(firsts, [*firsts[1:], VALUES], strict=True)]
    elsewhere = [j for j in middles if np.isfinite(squares[j]) and squares[j] != squares[VALUES // 2]]
    if not elsewhere:
        return []

    def slopes_here() -> Simulating[Evaluation]:
        here = yield from with_residual(found)
        return (yield from slopes(problem, others, here.theta, here.start, here.evaluation.residual, SPANS[-1]))

    (e,), least = together([slopes_here()]), list[Fit]()
    for first in range(0, len(elsewhere), AT_A_TIME):
        check()
        points = [search_point(problem, others, thetas[j], found.start) for j in elsewhere[first : first + AT_A_TIME]]
        least = sorted([*least, *together([step_by_slopes(f, e) for f in points])], key=lambda f: f.cost)[:CARRIED_ON]
    return least


def _middle_of_its_step(found: Fit, k: int, check: Callable[[], None]) -> float | None:
    """The middle of the step of its stairs on which a number is; None where the step ends nowhere near, or the number is 0."""
    if not found.theta[k]:
        return None
    for power in NARROWER:
        thetas, squares = _swept(found, k, REACH**power, check)
        other, here = np.flatnonzero(squares != squares[VALUES // 2]), VALUES // 2
        below, above = other[other < here], other[other > here]
        if len(below) and len(above):
            return float(thetas[below[-1] + 1][k] + thetas[above[0] - 1][k]) / 2.0
    return None


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
