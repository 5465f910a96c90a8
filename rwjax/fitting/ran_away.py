"""Estimates that ran away: far from where they began, and no surer for it.

What holds a part at rest looks like a number without end. Such an estimate follows the rounding of the last digits, and a rig
file with it simulates nothing.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from rwjax.errors import RigError
from rwjax.kinds import OTHER, RANGES
from rwjax.rig.effect_section import effect_parameters, rig_value
from rwjax.rig.model import Rig
from rwjax.rig.write import write_rig

FAR = 1000.0
"""Times its first size, or one SI unit where it began at 0, beyond which an estimate is far away [1]."""
VISCOUS = ".friction.viscous"
"""How the names of viscous frictions end that may be negative."""
UNSURE = 0.1
"""Standard error, as a share of the estimate, above which the logs do not say how large it is [1]."""


def ran_away(rig: Rig, fitted: Rig) -> tuple[str, ...]:
    """Free numbers that ran away in a fit, or out of the range that a rig file may hold.

    Of numbers that lie in their ranges and still make no rig together, all that are free count.

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
        unsure = not value <= FAR * first and not error < UNSURE * value
        if unsure or not _may_stand(name, fitted.values[name]):
            found.append(name)
    if not _may_be_written(_without(rig, fitted, found)):  # numbers that no rig has together
        found = [name for name in fitted.free if name in values]
    return tuple(found)


def _may_be_written(rig: Rig) -> bool:
    """Whether a rig file may hold a rig's numbers."""
    try:
        write_rig(rig)
    except RigError:
        return False
    return True


def _may_stand(name: str, value: float) -> bool:
    """Whether a rig file may hold a number."""
    try:
        rig_value(name, value)
    except RigError:
        return False
    return True


def without_runaways(rig: Rig, fitted: Rig) -> Rig:
    """A fitted rig in which the numbers that ran away are those of the rig as it was, or where it has none, at their range's end.

    Args:
        rig: The rig as it was.
        fitted: The rig with estimates and standard errors.

    Returns:
        The rig, without standard errors of these numbers.
    """
    return _without(rig, fitted, ran_away(rig, fitted))


def _without(rig: Rig, fitted: Rig, names: Sequence[str]) -> Rig:
    """A fitted rig in which some numbers are those of the rig as it was, and those that it lacked lie in their range."""
    kept = {name: error for name, error in fitted.standard_error.items() if name not in names}
    own = {name: _within_range(name, value) for name, value in fitted.values.items() if name not in rig.values}
    before = fitted.with_values(own | {name: rig.values[name] for name in names})
    return replace(before, guessed=rig.guessed).with_standard_errors(kept)


def _within_range(name: str, value: float) -> float:
    """A number of an effect within the range of its unit."""
    if _may_stand(name, value):
        return value
    effect, _, parameter = name.rpartition(".")
    known = effect_parameters()[effect][parameter]
    most = RANGES.get(known.unit, OTHER).most
    low, high = max(known.bounds[0], -most), min(known.bounds[1], most)
    return min(max(value, low), high)


def runaway_words(rig: Rig, fitted: Rig) -> list[str]:
    """What to do about estimates that ran away.

    Args:
        rig: The rig as it was.
        fitted: The rig with estimates and standard errors.

    Returns:
        One sentence for each [SI].
    """
    weight = "" if any(".gravity." in name for name in rig.numbers) else ", such as a weight (`[axis.gravity]`)"
    return [
        f"{name} ran away from {rig.values[name]:.4g} to {fitted.values[name]:.2g} ± "
        f"{fitted.standard_error.get(name, np.inf):.1g}: these logs do not tell it, or the rig lacks what holds that part{weight}; use runs "
        "in which it moves, give it `fit.bounds` or a `fit.prior`, or take it out of `fit.free`"
        for name in ran_away(rig, fitted)
    ]


def negative_friction(free: Iterable[str], values: Mapping[str, float]) -> list[str]:
    """What negative estimates of viscous frictions may come from: such a friction drives the motion on.

    Args:
        free: Names of the numbers that were estimated.
        values: Their estimates by name [SI].

    Returns:
        One sentence for each.
    """
    return [
        f"viscous friction came out negative: {name} = {values[name]:.3g} drives the motion on; likely the dry friction falls with the "
        "speed or is not in the rig file, a fixed number (gain, torque constant, resistance) is wrong and brakes too much, or these logs "
        "hardly tell it"
        for name in free
        if name.endswith(VISCOUS) and values.get(name, 0.0) < 0.0
    ]
