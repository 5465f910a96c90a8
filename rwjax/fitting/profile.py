r"""Profile intervals: how far a number may go while all others are fitted again.

A standard error says little where the cost is no parabola: for a number on its bound, or one that the logs hardly
determine. A value belongs to the 95 % interval while $2\,\Delta C/c \le \chi^2_{1,0.95}$. Here $C$ is half the sum of
squares in units of noise, and $c$ the ratio of the sandwich variance to the variance that independent residuals would
give (Rotnitzky and Jewell, Biometrika 77, 1990): correlated residuals count as few.
"""

from collections.abc import Callable
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from rwjax.fitting.multiple_shooting import Fit, least_squares

CHI_SQUARED_95 = NormalDist().inv_cdf(0.975) ** 2
"""95 % quantile of chi squared with one degree of freedom [1]."""
MOST_REFITS = 25
"""Refits on a side, each outward step twice as long as the last one, after which the side counts as open."""
MOST_STEPS = 20
"""Steps of a refit [1]."""
COARSEST = 1e-4
"""Largest share of the cost below which a step's gain ends a refit [1]; it ends earlier at a tenth of `CLOSE`."""
CLOSE = 0.02
"""Distance from the limit, as a share of it, at which a search ends [1]."""


class _Point(NamedTuple):
    """A refit at a value of the number, and by how much the cost has grown there, in units of what it may grow by."""

    value: float
    grown: float
    fit: Fit


def interval(
    fitted: Fit, number: int, inflation: float, unit: float, check: Callable[[], None] = lambda: None
) -> tuple[float, float]:
    """95 % interval of a free number by its profile.

    Args:
        fitted: The fit.
        number: Entry of `theta`.
        inflation: $c$ above [1].
        unit: First step outwards [SI].
        check: Is called before every step of a refit; what it raises ends the profile.

    Returns:
        Lower and upper end [SI]: infinite, or the bound, on a side that the logs leave open.
    """
    k = int(np.flatnonzero(fitted.coordinates.index == number)[0])
    low, high = map(float, fitted.coordinates.bounds[k])
    growth = CHI_SQUARED_95 * inflation / 2.0
    return _side(fitted, number, growth, -unit, low, check), _side(fitted, number, growth, unit, high, check)


def _side(fitted: Fit, number: int, growth: float, unit: float, bound: float, check: Callable[[], None]) -> float:
    """One end of the interval, at which the cost has grown by `growth`: steps outwards until it is passed, then the root."""
    others = fitted.coordinates.without(number)
    best = float(fitted.theta[number])
    inside, outside = _Point(best, 0.0, fitted), None
    before, step, value = inside, unit, best
    for _ in range(MOST_REFITS):
        if outside is None:
            value = inside.value + step
            step *= 2.0
            if (value - bound) * np.sign(unit) >= 0.0:
                value = bound
        else:  # the root of the growth is about linear in the value
            share = (1.0 - np.sqrt(inside.grown)) / (np.sqrt(outside.grown) - np.sqrt(inside.grown))
            value = inside.value + float(np.clip(share, 0.1, 0.9)) * (outside.value - inside.value)
        theta, start = _between(outside if outside and outside.fit.converged else before, inside, value)
        theta[number] = value
        tolerance = min(0.1 * CLOSE * growth / max(inside.fit.cost, 1.0), COARSEST)
        trial = least_squares(
            fitted.problem, others, theta, start=start, most_steps=MOST_STEPS, tolerance=tolerance, check=check
        )
        point = _Point(value, max(trial.cost - fitted.cost, 0.0) / growth, trial)
        if point.grown <= 1.0:
            before, inside = inside, point
            if value == bound:
                return bound
        else:
            outside = point
        if abs(point.grown - 1.0) < CLOSE:
            return float(value)
        if outside is not None and abs(outside.value - inside.value) < 1e-3 * abs(outside.value - best):
            break
    return float(value) if outside is not None else float(np.copysign(np.inf, unit))


def _between(a: _Point, b: _Point, value: float) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and initial states on the line through two refits: where the one at another value begins."""
    share = (value - b.value) / (b.value - a.value) if b.value != a.value else 0.0
    move = [y + share * (y - x) for x, y in ((a.fit.theta, b.fit.theta), (a.fit.start, b.fit.start))]
    return (move[0], move[1]) if all(np.isfinite(m).all() for m in move) else (b.fit.theta.copy(), b.fit.start)
