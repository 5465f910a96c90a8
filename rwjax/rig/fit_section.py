"""The section `[fit]` of a rig file: which numbers are estimated, within which bounds, and what is known of them."""

import math
from collections.abc import Collection
from typing import Any, NamedTuple

from rwjax.errors import RigError, nearest
from rwjax.kinds import COEFFICIENTS, KEYS, NUMBERS, POLYNOMIAL
from rwjax.rig.document import number, shown
from rwjax.rig.effect_section import effect_parameters, rig_value

BEST_KNOWN = 1e-6
"""Least standard deviation of a prior over the size of its number [1]: beside a better one no logs count."""
LEAST_KNOWN = 1e-12
"""Size that a number counts as having where it is smaller, in its own SI unit; its inverse is the largest standard deviation."""


class FitTables(NamedTuple):
    """The tables below `[fit]` as the file holds them, number name -> unchecked value.

    Attributes:
        standard_error: `[fit.standard_error]`.
        bounds: `[fit.bounds]`.
        prior: `[fit.prior]`.
        tied: `[fit.tied]`.
    """

    standard_error: dict[str, Any]
    bounds: dict[str, Any]
    prior: dict[str, Any]
    tied: dict[str, Any]


class FitSection(NamedTuple):
    """The section `[fit]`, checked; the fields are those of `Rig`.

    Attributes:
        free: Names of the numbers that a fit estimates.
        per_run: Those of `free` of which every log has a value of its own.
        bounds: Lowest and highest value [SI] by name.
        prior: Mean and standard deviation [SI] by name, from elsewhere than the logs.
        standard_error: Standard error [SI] of an earlier estimate by name.
    """

    free: tuple[str, ...]
    per_run: tuple[str, ...]
    bounds: dict[str, tuple[float, float]]
    prior: dict[str, tuple[float, float]]
    standard_error: dict[str, float]


def fit_section(leaves: dict[str, Any], tables: FitTables, values: dict[str, float], kind: str) -> FitSection:
    """The section `[fit]` of a rig file.

    Args:
        leaves: Values of the file by dotted name, with `fit.free` and `fit.per_run`.
        tables: The tables below `[fit]`.
        values: The rig's numbers and effect parameters [SI] by name.
        kind: Kind of the rig.

    Returns:
        The section, checked against `values`.

    Raises:
        RigError: For a name that the file holds no value of, and for values that cannot be.
    """
    free = _names(leaves, "fit.free", values, kind)
    for key, names in (("fit.free", free), ("fit.bounds", tables.bounds), ("fit.prior", tables.prior)):
        if both := next((name for name in names if name in tables.tied), None):
            raise RigError(
                f"`{key}` names `{both}`, which follows from others by `fit.tied`; take it out of one of them"
            )
    bounds = {name: _bound(name, pair, values, kind) for name, pair in tables.bounds.items()}
    anything = (-math.inf, math.inf)
    return FitSection(
        free=free,
        per_run=_per_run(leaves, free, values, kind),
        bounds=bounds,
        prior={
            name: _prior(name, pair, free, values, bounds.get(name, anything)) for name, pair in tables.prior.items()
        },
        standard_error={
            name: _standard_error(name, value, values, kind) for name, value in tables.standard_error.items()
        },
    )


def _names(leaves: dict[str, Any], key: str, values: dict[str, float], kind: str) -> tuple[str, ...]:
    """The names of numbers that `key` lists, the polynomial written out as its four coefficients."""
    given = leaves.get(key, [])
    if not isinstance(given, list) or not all(isinstance(name, str) for name in given):
        raise RigError(f'`{key}` is {shown(given)}; it has to be a list of names, such as ["axis.inertia"]')
    held: dict[str, tuple[str, ...]] = {name: (name,) for name in values}
    if COEFFICIENTS[0] in values:
        held[POLYNOMIAL] = COEFFICIENTS
    for name in given:
        _check_held(name, held, key, kind)
    listed = tuple(each for name in given for each in held[name])
    if twice := next((name for i, name in enumerate(listed) if name in listed[:i]), None):
        raise RigError(f"`{key}` names `{twice}` twice; name it once")
    return listed


def _per_run(leaves: dict[str, Any], free: tuple[str, ...], values: dict[str, float], kind: str) -> tuple[str, ...]:
    """The names in `fit.per_run`, all of them free."""
    listed = _names(leaves, "fit.per_run", values, kind)
    if fixed := next((name for name in listed if name not in free), None):
        raise RigError(f"`fit.per_run` names `{fixed}`, which is not estimated; name it in `fit.free` too")
    if absent := next((name for name in listed if name.endswith(".inductance") and values[name] == 0.0), None):
        raise RigError(f"`fit.per_run` names `{absent}`, which is 0 and left out; give it a starting value")
    return listed


def _check_held(name: str, held: Collection[str], where: str, kind: str) -> None:
    """`RigError` if the name that `where` uses has no value in the file."""
    if name in held:
        return
    numbers = [n for n, kinds in KEYS.items() if kind in kinds and (n in NUMBERS or n == POLYNOMIAL)]
    if name in numbers or name in {f"{e}.{p}" for e, known in effect_parameters().items() for p in known}:
        raise RigError(f"`{where}` names `{name}`, which has no value in this file; give it a starting value")
    raise RigError(f"`{where}` names `{name}`, no number of this file; the nearest is `{nearest(name, held)}`")


def _bound(name: str, pair: Any, values: dict[str, float], kind: str) -> tuple[float, float]:
    """Lowest and highest value [SI] of a number, which lies between them."""
    _check_held(name, values, "fit.bounds", kind)
    key = f"fit.bounds.{name}"
    if not isinstance(pair, list) or len(pair) != 2:
        raise RigError(f"`{key}` is {shown(pair)}; it has to be [lowest, highest]")
    low, high = (number(key, value, finite=False) for value in pair)
    if not low < high:
        raise RigError(f"`{key}` is [{low!r}, {high!r}]; the first has to be below the second")
    if not low <= values[name] <= high:
        raise RigError(f"`{name}` is {values[name]!r}, outside its `fit.bounds` [{low!r}, {high!r}]; widen them")
    return low, high


def _prior(
    name: str, pair: Any, free: tuple[str, ...], values: dict[str, float], bounds: tuple[float, float]
) -> tuple[float, float]:
    """Mean and standard deviation [SI] of what is known of a free number from elsewhere than the logs."""
    key = f"fit.prior.{name}"
    if name not in free:
        raise RigError(f"`{key}` is of no use, since `{name}` is not estimated; name it in `fit.free`, or take it out")
    if not isinstance(pair, list) or len(pair) != 2:
        raise RigError(f"`{key}` is {shown(pair)}; it has to be [mean, standard deviation]")
    mean = rig_value(name, pair[0], key)
    if not bounds[0] <= mean <= bounds[1]:
        raise RigError(
            f"`{key}` has the mean {mean!r}, outside the number's `fit.bounds` [{bounds[0]!r}, {bounds[1]!r}]"
        )
    deviation = number(key, pair[1], "positive")
    least, most = BEST_KNOWN * max(abs(mean), abs(values[name]), LEAST_KNOWN), 1.0 / LEAST_KNOWN
    if not least <= deviation <= most:
        raise RigError(
            f"`{key}` has the standard deviation {deviation!r}; it lies between {least:g} and {most:g} (SI); a number that is "
            "known better is not estimated: take it out of `fit.free`"
        )
    return mean, deviation


def _standard_error(name: str, value: Any, values: dict[str, float], kind: str) -> float:
    """Standard error [SI] of a number; infinite where the logs said nothing about it."""
    _check_held(name, values, "fit.standard_error", kind)
    return number(f"fit.standard_error.{name}", value, "zero or positive", finite=False)
