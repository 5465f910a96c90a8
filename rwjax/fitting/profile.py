r"""Profile intervals: how far a number may go while all others are fitted again.

Where the sum of squares is no parabola (a number at its bound, one that the logs hardly tell), a standard error says
little. A value belongs to the 95 % interval while $2\,\Delta C/c \le \chi^2_{1,0.95}$, with $C$ half the sum of squares
in units of noise, and $c$ the ratio of the sandwich variance to the one that independent residuals would give
(Rotnitzky and Jewell, Biometrika 77, 1990), so that correlated residuals count as few as they are.
"""

from statistics import NormalDist

import numpy as np

from rwjax.fitting.multiple_shooting import Fit, least_squares

INSIDE = NormalDist().inv_cdf(0.975) ** 2  # of chi squared with one degree of freedom
FARTHEST = 25
"""Steps, each outward one twice as long as the last, after which a side counts as open."""
CLOSE = 0.02
"""Distance from the limit, as a share of it, at which a search ends."""


def interval(fitted: Fit, number: int, inflation: float, unit: float) -> tuple[float, float]:
    """95 % interval of the free number `theta[number]`; infinite, or its bound, on a side that the logs leave open.

    `inflation`: $c$ above; `unit`: first step outwards [SI].
    """
    k = int(np.flatnonzero(fitted.coordinates.index == number)[0])
    low, high = map(float, fitted.coordinates.bounds[k])
    return _side(fitted, number, inflation, -unit, low), _side(fitted, number, inflation, unit, high)


def _side(fitted: Fit, number: int, inflation: float, unit: float, bound: float) -> float:
    others = fitted.coordinates.without(number)
    best = value = float(fitted.theta[number])
    last, inside, outside, step = fitted, best, None, unit
    left_inside, left_outside = 0.0, np.inf
    for _ in range(FARTHEST):
        if outside is None:
            value = inside + step
            step *= 2.0
            if (value - bound) * np.sign(unit) >= 0.0:
                value = bound
        else:  # between a value inside and one outside: the root of 2 ΔC/c grows about linearly
            share = (np.sqrt(INSIDE) - np.sqrt(left_inside)) / (np.sqrt(left_outside) - np.sqrt(left_inside))
            value = inside + float(np.clip(share, 0.1, 0.9)) * (outside - inside)
        theta = last.theta.copy()
        theta[number] = value
        trial = least_squares(fitted.problem, others, theta, start=last.start, most_steps=20, tolerance=1e-6)
        left = max(2.0 * (trial.cost - fitted.cost) / inflation, 0.0)
        if left <= INSIDE:
            inside, left_inside, last = value, left, trial
            if value == bound:
                return bound
        else:
            outside, left_outside = value, left
        if abs(left - INSIDE) < CLOSE * INSIDE:
            return float(value)
        if outside is not None and abs(outside - inside) < 1e-3 * abs(outside - best):
            break
    return float(value) if outside is not None else float(np.copysign(np.inf, unit))
