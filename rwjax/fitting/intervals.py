"""95 % intervals of a fit's numbers: by the standard error, by the profile where that says little, by the bootstrap where
one is asked for."""

import numpy as np

from rwjax.fitting.bootstrap import bootstrap as resampled
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.profile import interval as profile
from rwjax.fitting.uncertainty import Uncertainty

NORMAL_95 = 1.96
WIDE = 0.2
"""Length of an interval, as a share of the number, above which the sum of squares of a positive number may be no parabola."""
FIRST_STEP = 0.05
"""First step of a profile where there is no standard error, in units of the number's size."""

Intervals = dict[str, tuple[float, float]]


def intervals(fitted: Fit, spread: Uncertainty, draws: int) -> tuple[Intervals, list[str]]:
    """Interval of each free number [SI] and, where it is not the standard error's, a sentence; `draws` of the bootstrap,
    0 for none. A number of which the logs say nothing has its bounds.
    """
    moves = fitted.coordinates
    on_bound = np.logical_or(*moves.on_bound(fitted.theta))
    found, notes = {}, []
    drawn = np.percentile(resampled(fitted, draws), (2.5, 97.5), axis=0).T if draws else None
    for k, name in enumerate(fitted.free):
        error = spread.standard_error[name]
        low, high = found[name] = _normal(fitted, error, k)
        if not np.isfinite(error) and not on_bound[k]:
            found[name] = float(moves.bounds[k, 0]), float(moves.bounds[k, 1])
        elif drawn is not None and np.isfinite(error):
            low, high = found[name] = float(drawn[k, 0]), float(drawn[k, 1])
            notes.append(f"{name}: 95 % from {low:.6g} to {high:.6g} by {draws} refits")
        elif not np.isfinite(error) or not _parabolic(fitted, low, high, k):
            unit = error if np.isfinite(error) else FIRST_STEP * moves.size[k]
            low, high = found[name] = profile(fitted, int(moves.index[k]), float(spread.inflation[k]), float(unit))
            notes.append(
                f"{name}: 95 % from {low:.3g} to {high:.3g} by its profile, since a standard error says little"
            )
    return found, notes


def _normal(fitted: Fit, error: float, k: int) -> tuple[float, float]:
    value = float(fitted.theta[fitted.coordinates.index[k]])
    return value - NORMAL_95 * error, value + NORMAL_95 * error


def _parabolic(fitted: Fit, low: float, high: float, k: int) -> bool:
    """Whether a standard error describes what the logs say of a free number: no bound near, and if it is a number of one
    sign, an interval that is short against it."""
    least, most = fitted.coordinates.bounds[k]
    one_sign = np.isfinite(least) or np.isfinite(most)
    return bool(least < low and high < most and (not one_sign or high - low < WIDE * abs(low + high) / 2.0))
