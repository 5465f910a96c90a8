r"""Profile intervals: how far a number may go while all others are fitted again.

A standard error says little where the cost is no parabola: for a number on its bound, or one that the logs hardly
determine. A value belongs to the 95 % interval while $2\,\Delta C/c \le \chi^2_{1,0.95}$. Here $C$ is half the sum of
squares in units of noise, and $c$ the ratio of the sandwich variance to the variance that independent residuals would
give (Rotnitzky and Jewell, Biometrika 77, 1990): correlated residuals count as few.
"""

from statistics import NormalDist

import numpy as np

from rwjax.fitting.multiple_shooting import Fit, least_squares

CHI_SQUARED_95 = NormalDist().inv_cdf(0.975) ** 2
"""95 % quantile of chi squared with one degree of freedom [1]."""
MOST_REFITS = 25
"""Refits on a side, each outward step twice as long as the last one, after which the side counts as open."""
CLOSE = 0.02
"""Distance from the limit, as a share of it, at which a search ends [1]."""


def interval(fitted: Fit, number: int, inflation: float, unit: float) -> tuple[float, float]:
    """95 % interval of a free number by its profile.

    Args:
        fitted: The fit.
        number: Entry of `theta`.
        inflation: $c$ above [1].
        unit: First step outwards [SI].

    Returns:
        Lower and upper end [SI]: infinite, or the bound, on a side that the logs leave open.
    """
    k = int(np.flatnonzero(fitted.coordinates.index == number)[0])
    low, high = map(float, fitted.coordinates.bounds[k])
    return _side(fitted, number, inflation, -unit, low), _side(fitted, number, inflation, unit, high)


def _side(fitted: Fit, number: int, inflation: float, unit: float, bound: float) -> float:
    """One end of the interval: steps outwards until a value lies outside, then the root between both."""
    others = fitted.coordinates.without(number)
    best = value = float(fitted.theta[number])
    last, inside, outside, step = fitted, best, None, unit
    grown_inside, grown_outside = 0.0, np.inf
    for _ in range(MOST_REFITS):
        if outside is None:
            value = inside + step
            step *= 2.0
            if (value - bound) * np.sign(unit) >= 0.0:
                value = bound
        else:  # the root of 2 ΔC/c grows about linearly
            share = (np.sqrt(CHI_SQUARED_95) - np.sqrt(grown_inside)) / (np.sqrt(grown_outside) - np.sqrt(grown_inside))
            value = inside + float(np.clip(share, 0.1, 0.9)) * (outside - inside)
        theta = last.theta.copy()
        theta[number] = value
        trial = least_squares(fitted.problem, others, theta, start=last.start, most_steps=20, tolerance=1e-6)
        grown = max(2.0 * (trial.cost - fitted.cost) / inflation, 0.0)
        if grown <= CHI_SQUARED_95:
            inside, grown_inside, last = value, grown, trial
            if value == bound:
                return bound
        else:
            outside, grown_outside = value, grown
        if abs(grown - CHI_SQUARED_95) < CLOSE * CHI_SQUARED_95:
            return float(value)
        if outside is not None and abs(outside - inside) < 1e-3 * abs(outside - best):
            break
    return float(value) if outside is not None else float(np.copysign(np.inf, unit))
