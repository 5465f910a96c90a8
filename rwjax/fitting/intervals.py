"""95 % intervals of a fit's numbers.

The standard error gives them; the profile where a standard error says little; the bootstrap where one is asked for.
"""

from collections.abc import Callable
from time import monotonic

import numpy as np

from rwjax.fitting.bootstrap import bootstrap
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.profile import interval
from rwjax.fitting.uncertainty import Uncertainty
from rwjax.plant.from_rig import SMALLEST

NORMAL_95 = 1.96
"""Standard errors to either end of a 95 % interval [1]."""
WIDE = 0.2
"""Length of an interval, as a share of a positive number, above which the cost may be no parabola [1]."""
FIRST_STEP = 0.05
"""First step of a profile where there is no standard error, in units of the number's size [1]."""

MOST_TIME = 20.0
"""Time that the profiles of a fit may take together [s]: those of numbers that hardly any log tells go on for minutes."""

Intervals = dict[str, tuple[float, float]]
"""Lower and upper end by name [SI]."""


def intervals(
    fitted: Fit, errors: Uncertainty, draws: int, progress: Callable[[str], None], roughly: Fit
) -> tuple[Intervals, list[str]]:
    """95 % interval of each free number.

    A number that the logs say nothing about has its bounds. Through a smooth solver no profiles are made, and none after `MOST_TIME`.

    Args:
        fitted: The fit.
        errors: Its standard errors.
        draws: Refits of the bootstrap, 0 for none [1].
        progress: Hears of what takes long.
        roughly: The fit, or the same one in coarser time steps, whose profiles take less time and tell as well how far a number may go.

    Returns:
        The intervals [SI], and a sentence for each that does not come from the standard error.
    """
    moves = fitted.coordinates
    on_bound = np.logical_or(*moves.on_bound(fitted.theta))
    found, notes, late = {}, [], []
    if draws:
        progress(f"{draws} refits to resampled stretches")
    drawn = np.percentile(bootstrap(fitted, draws), (2.5, 97.5), axis=0).T if draws else None
    check = _timer(MOST_TIME)
    for k, name in enumerate(fitted.free):
        error = errors.standard_error[name]
        low, high = found[name] = _normal(fitted, error, k)
        if not np.isfinite(error) and not on_bound[k]:
            found[name] = float(moves.bounds[k, 0]), float(moves.bounds[k, 1])
        elif drawn is not None and np.isfinite(error):
            low, high = found[name] = float(drawn[k, 0]), float(drawn[k, 1])
            notes.append(f"{name}: 95 % from {low:.6g} to {high:.6g} by {draws} refits")
        elif np.isfinite(error) and _parabolic(fitted, low, high, k):
            continue
        elif fitted.problem.solver.smooth:  # a profile takes some twenty refits, each as long as the fit
            if not np.isfinite(error):
                found[name] = float(moves.bounds[k, 0]), float(moves.bounds[k, 1])
            notes.append(f"{name}: a standard error says little; a fit by the exact solver gives its profile")
        else:
            progress(f"how far {name} may go, {k + 1} of {len(fitted.free)} numbers")
            unit = float(error if np.isfinite(error) else FIRST_STEP * moves.size[k])
            try:
                ends = _profile(fitted, roughly, k, float(errors.inflation[k]), unit, check)
            except _OutOfTime:
                found[name] = max(low, float(moves.bounds[k, 0])), min(high, float(moves.bounds[k, 1]))
                late.append(name)
                continue
            found[name] = ends
            low, high = map(float, moves.bounds[k])
            notes.append(
                f"{name}: {interval_words(*ends, 3, (low, high))} by its profile, since a standard error says little"
            )
    if late:
        notes.append(
            f"{', '.join(late)}: a standard error says little; there is no profile, since those of all numbers had taken {MOST_TIME:g} s"
        )
    return found, notes


def _profile(
    fitted: Fit, roughly: Fit, k: int, inflation: float, unit: float, check: Callable[[], None]
) -> tuple[float, float]:
    """95 % interval of a free number by the profile of a rougher fit, or of the fit itself where that one's does not hold the estimate."""
    number = int(fitted.coordinates.index[k])
    low, high = interval(roughly, number, inflation, unit, check)
    if low <= fitted.theta[number] <= high:
        return low, high
    return interval(fitted, number, inflation, unit, check)


class _OutOfTime(Exception):
    """Raised where the profiles have taken their time."""


def _timer(seconds: float) -> Callable[[], None]:
    """What raises `_OutOfTime` from some time after now on [s]."""
    end = monotonic() + seconds

    def check() -> None:
        if monotonic() > end:
            raise _OutOfTime

    return check


def interval_words(low: float, high: float, digits: int = 6, allowed: tuple[float, float] = (-np.inf, np.inf)) -> str:
    """A 95 % interval in words.

    Args:
        low: Lower end [any unit].
        high: Upper end [same unit]; an end that is not finite is open.
        digits: Significant digits of the ends.
        allowed: Least and largest value that the number may have [same unit]: an end there is open, too, but for a least value of 0.

    Returns:
        Such as `95 %: 0.1 to 0.2`.
    """
    first, last, least, most = (f"{end:.{digits}g}" for end in (low, high, *allowed))
    has_least, has_most = abs(allowed[0]) > SMALLEST and np.isfinite(allowed[0]), np.isfinite(allowed[1])
    from_least, to_most = not low > allowed[0], not high < allowed[1]
    if from_least and to_most:
        return "95 %: any value" + (f" of those allowed, {least} to {most}" if np.isfinite(allowed).all() else "")
    if to_most:
        return f"95 %: above {first}" + (f", up to all that is allowed, {most}" if has_most else "")
    if from_least and not (allowed[0] == 0.0 and np.isfinite(low)):
        return f"95 %: below {last}" + (f", down to all that is allowed, {least}" if has_least else "")
    return f"95 %: {first} to {last}"


def _normal(fitted: Fit, error: float, k: int) -> tuple[float, float]:
    """Interval of a free number by its standard error."""
    value = float(fitted.theta[fitted.coordinates.index[k]])
    return value - NORMAL_95 * error, value + NORMAL_95 * error


def _parabolic(fitted: Fit, low: float, high: float, k: int) -> bool:
    """Whether a standard error describes what the logs say of a free number.

    It does where no bound is near and, for a number of one sign, the interval is short against it.
    """
    least, most = fitted.coordinates.bounds[k]
    one_sign = np.isfinite(least) or np.isfinite(most)
    return bool(least < low and high < most and (not one_sign or high - low < WIDE * abs(low + high) / 2.0))
