"""Estimates that ran away: far from where they began, and no surer for it.

What holds a part at rest looks like a number without end. Such an estimate follows the rounding of the last digits, and a rig
file with it simulates nothing.
"""

from dataclasses import replace

import numpy as np

from rwjax.rig.model import Rig

FAR = 1000.0
"""Times its first size, or one SI unit where it began at 0, beyond which an estimate is far away [1]."""
UNSURE = 0.1
"""Standard error, as a share of the estimate, above which the logs do not say how large it is [1]."""


def ran_away(rig: Rig, fitted: Rig) -> tuple[str, ...]:
    """Free numbers that ran away in a fit.

    Args:
        rig: The rig as it was.
        fitted: The rig with estimates and standard errors.

    Returns:
        The names of the numbers.
    """
    values, found = rig.values, []
    for name in (name for name in fitted.free if name in values):
        first, value, error = (
            abs(values[name]) or 1.0,
            abs(fitted.values[name]),
            fitted.standard_error.get(name, np.inf),
        )
        if not value <= FAR * first and not error < UNSURE * value:
            found.append(name)
    return tuple(found)


def without_runaways(rig: Rig, fitted: Rig) -> Rig:
    """A fitted rig in which the numbers that ran away are those of the rig as it was.

    Args:
        rig: The rig as it was.
        fitted: The rig with estimates and standard errors.

    Returns:
        The rig, without standard errors of these numbers.
    """
    names = ran_away(rig, fitted)
    kept = {name: error for name, error in fitted.standard_error.items() if name not in names}
    return replace(fitted.with_values({name: rig.values[name] for name in names}), standard_error=kept)


def runaway_words(rig: Rig, fitted: Rig) -> list[str]:
    """What to do about estimates that ran away.

    Args:
        rig: The rig as it was.
        fitted: The rig with estimates and standard errors.

    Returns:
        One sentence for each [SI].
    """
    return [
        f"{name} ran away from {rig.values[name]:.4g} to {fitted.values[name]:.2g} ± "
        f"{fitted.standard_error.get(name, np.inf):.1g}: these logs do not tell it; use runs in which that part moves, give it "
        "`fit.bounds` or a `fit.prior`, or take it out of `fit.free`"
        for name in ran_away(rig, fitted)
    ]
