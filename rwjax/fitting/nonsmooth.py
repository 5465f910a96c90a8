"""Least squares where stick-slip makes the cost nonsmooth.

The exact derivative at a point describes only its neighbourhood. Secants over a wider span show how the cost falls over
the whole valley.
"""

from dataclasses import replace

import numpy as np

from rwjax.effects.library import dry_numbers
from rwjax.fitting.batched_runs import Simulating, together
from rwjax.fitting.multiple_shooting import Fit, least_squares, reaches_noise
from rwjax.fitting.problem import Problem
from rwjax.fitting.secant import descend, with_residual

SPANS = (0.03, 0.01, 0.003)
"""Spans of the secants in coordinates: logarithms, or shares of the number's own size [1]."""
MOST_STEPS = 12
"""Secant steps at most."""
TOLERANCE = 1e-3
"""Share of the cost below which a step's gain leads to the next span [1]."""


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
    return not np.all(np.einsum("lkk->k", found.evaluation.H)[: len(found.coordinates.index)])


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
    return replace(rest, steps=rest.steps + found.steps) if rest.cost < found.cost else found
