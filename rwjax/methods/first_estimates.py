"""Numbers of a first rig file by a regression on its logs: those that the logs tell, and what becomes of the others."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from rwjax.errors import InputError
from rwjax.kinds import NUMBERS
from rwjax.logs.log import Log
from rwjax.methods.identified import NORMAL_95
from rwjax.methods.known import Known
from rwjax.methods.regression import weak_form
from rwjax.rig.model import Rig

REGRESSION = "by a regression; `rwjax fit` estimates it anew"
DIGITS = 3
"""Digits of an estimate, which `fit` will make anew."""
TORQUE_CONSTANT = "motor.torque_constant"
WEIGHT, WEIGHT_ANGLE = "axis.gravity.torque", "axis.gravity.angle"
FAR_FROM_MASS = 1.5
"""Factor by which an estimate may differ from what a mass and a length give without a word [1]: a rod that is taken for a bob differs by 2 and by 3."""
UNTOLD = 1e3
"""Standard error of a friction, in guesses of it, above which a regression says nothing of it [1]."""
FASTER = 1.1
"""Speed per volt in the logs, over the datasheet's, from which on they do not go together [1]: no friction makes a motor faster, and a
catalogue's speeds hold within 10 %."""
SLOWER = 0.5
"""The same where the logs are slower [1]: friction would take more of the voltage than the back-EMF, and of a motor without a load it
takes a small part."""


class FirstEstimates(NamedTuple):
    """Numbers of a first rig file after a regression.

    Attributes:
        numbers: Every number by its name [SI].
        notes: What the logs do not tell, a sentence each.
    """

    numbers: dict[str, Known]
    notes: tuple[str, ...] = ()


def rounded(value: float) -> float:
    """A number with the digits that a first rig file gives it.

    Args:
        value: The number [any unit].

    Returns:
        The same, rounded [any unit].
    """
    return float(f"{value:.{DIGITS}g}")


def first_estimates(
    rig: Rig, logs: Sequence[Log], numbers: dict[str, Known], *, by_no_load_speed: bool = False
) -> FirstEstimates:
    """Estimates of the free numbers by the weak form.

    * Friction that is not above 0 by its own standard error is none: it is 0, and fixed. Of several the one that is told least goes first,
      since two may stand for each other. The last free number stays free, unless the torque constant is free in its place.
      Friction whose standard error is a thousand times its guess and more is not told, and keeps its guess.
    * Any other number that is smaller than its error keeps its guess, and a fit tries again.
    * A negative weight is a positive one that stands up at angle 0, and is written so. An estimate that differs by a factor of 1.5 and more from what a mass and a length
      give is said.
    * A torque constant by a speed without a load is compared with the speed per volt of the logs. It is free where friction would have to
      be negative to explain them.

    Args:
        rig: The rig of these numbers.
        logs: Its logs.
        numbers: Every number by its name [SI].
        by_no_load_speed: Whether the torque constant is the voltage over a datasheet's speed without a load.

    Returns:
        The numbers with the estimates, and notes.

    Raises:
        LogError: As `weak_form` does.
        RigError: As `weak_form` does.
    """
    speed, error = (_speed_per_volt(rig, logs) if by_no_load_speed else None) or (1.0, 0.0)
    too_fast = speed > 1.0 + NORMAL_95 * error
    found, none = _without_friction(rig, logs, least=0 if too_fast else 1)
    untold = [n for n, at in none.items() if at.standard_error.get(n, math.inf) > UNTOLD * numbers[n].value > 0.0]
    none = {n: at for n, at in none.items() if n not in untold}
    notes = [_no_friction(at, n) for n, at in none.items()]
    numbers = numbers | {n: Known(0.0, "a regression finds none; to estimate it anew, add it to free") for n in none}
    if freed := too_fast and bool(none):
        numbers[TORQUE_CONSTANT] = numbers[TORQUE_CONSTANT]._replace(free=True)
    if freed or not SLOWER < speed < FASTER:
        notes.append(_of_speed(speed, freed))
    free = tuple(n for n in numbers if numbers[n].free)
    if freed:
        found = weak_form(replace(rig.with_values(dict.fromkeys(none, 0.0)), free=free), logs).rig
    for n in free:
        if told(found, n):
            notes += _far_from_mass(found, n, numbers[n])
            numbers = numbers | _by_regression(numbers, n, found.values[n])
        else:
            known = numbers[n]
            numbers = numbers | {n: known._replace(why=f"{known.why}; a regression does not tell it")}
            notes.append(f"{n} stays {_said(n, known.value)}, {known.why}: a regression does not tell it")
    return FirstEstimates(numbers, tuple(notes))


def _without_friction(rig: Rig, logs: Sequence[Log], least: int) -> tuple[Rig, dict[str, Rig]]:
    """The regression without the frictions that are none, of which so many numbers at least stay, and these with the regression that found each so."""
    found, none = weak_form(rig, logs).rig, {}
    rest = found.free
    while len(rest) > least and (untold := [n for n in rest if _is_friction(n) and not told(found, n)]):
        worst = min(untold, key=lambda n: found.values[n] / found.standard_error.get(n, math.inf))
        none[worst] = found
        rest = tuple(n for n in rest if n != worst)
        if rest:
            found = weak_form(replace(rig.with_values(dict.fromkeys(none, 0.0)), free=rest), logs).rig
    return found, none


def _is_friction(name: str) -> bool:
    return ".friction" in name


def told(found: Rig, name: str) -> bool:
    """Whether an estimate is larger than its standard error; friction, and what cannot be negative, has to be above 0 by it.

    Args:
        found: The rig with estimates and standard errors [SI].
        name: Name of a free number.

    Returns:
        Whether the logs tell it.
    """
    value, error = found.values[name], found.standard_error.get(name, math.inf)
    above = _is_friction(name) or "positive" in NUMBERS[name].sign
    return (value if above else abs(value)) > error


def _by_regression(numbers: dict[str, Known], name: str, value: float) -> dict[str, Known]:
    """An estimate; of a negative weight the positive one, with its angle."""
    estimate = numbers[name]._replace(value=rounded(value), why=REGRESSION)
    if name != WEIGHT or value > 0.0 or WEIGHT_ANGLE not in numbers:
        return {name: estimate}
    stands = numbers[WEIGHT_ANGLE]._replace(
        value=round(math.pi, 6), why="by a regression the link stands up at angle 0"
    )
    return {name: estimate._replace(value=rounded(-value)), WEIGHT_ANGLE: stands}


def _far_from_mass(found: Rig, name: str, known: Known) -> list[str]:
    """A note on an estimate that is not what a mass and a length give."""
    value, error = found.values[name], NORMAL_95 * found.standard_error[name]
    if not known.by_mass or abs(value - known.value) < error:
        return []
    if name == WEIGHT and value < 0.0:
        return [
            f"{name}: by a regression the link stands up at angle 0; if it hangs down there, the angle or the command has the wrong sign"
        ]
    if 1.0 / FAR_FROM_MASS < value / known.value < FAR_FROM_MASS:
        return []
    return [
        f"{name}: a regression has {_said(name, value)} where the mass and the length give {_said(name, known.value)} ({known.why})"
    ]


def _said(name: str, value: float) -> str:
    """A value with its unit."""
    return f"{rounded(value):g} {NUMBERS[name].unit}"


def _no_friction(found: Rig, name: str) -> str:
    """A note on friction that is none."""
    error = found.standard_error.get(name)
    by = "" if error is None else f", {rounded(max(found.values[name], 0.0)):g} ± {error:.1g} {NUMBERS[name].unit}"
    return f"{name} is 0 and fixed: a regression finds none above its standard error{by}"


def _speed_per_volt(rig: Rig, logs: Sequence[Log]) -> tuple[float, float] | None:
    """Speed per volt of the logs over that of the torque constant and its error [1], all friction in the back-EMF; None if not told."""
    others = {n for n in rig.free if not _is_friction(n)}
    still = rig.with_values({n: 0.0 for n in rig.free if _is_friction(n)})
    try:
        found = weak_form(
            replace(still, free=tuple(n for n in rig.values if n in others | {TORQUE_CONSTANT})), logs
        ).rig
    except InputError:
        return None
    if not told(found, TORQUE_CONSTANT):
        return None
    speed = rig.values[TORQUE_CONSTANT] / found.values[TORQUE_CONSTANT]
    return speed, speed * found.standard_error[TORQUE_CONSTANT] / found.values[TORQUE_CONSTANT]


def _of_speed(speed: float, freed: bool) -> str:
    """A note on a speed without a load that the logs do not have."""
    says = f"--no-load-speed: these logs turn {speed:.3g} times as fast per volt as it says with --supply"
    if freed:
        return f"{says}, and no friction makes a motor faster: {TORQUE_CONSTANT} is free instead of the friction"
    return (
        f"{says}: is it of the same side of the gear and of the same voltage? Without it {TORQUE_CONSTANT} is estimated"
    )
