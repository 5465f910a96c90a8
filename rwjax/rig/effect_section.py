"""The section `[effects]` of a rig file: the effects that the rig has, with their parameters."""

import math
from typing import TYPE_CHECKING, Any

from rwjax.errors import RigError, nearest
from rwjax.kinds import NUMBERS
from rwjax.rig.document import number

if TYPE_CHECKING:
    from rwjax.effects.parameter import Parameter


def effect_parameters(kind: str | None = None) -> "dict[str, dict[str, Parameter]]":
    """The parameters of every known effect.

    Args:
        kind: Kind of rig; without it, effects of all kinds.

    Returns:
        Effect name -> parameter name -> what is known of the parameter.
    """
    # The effects import JAX, which takes about a second: most rig files name none, and are read without it.
    from rwjax.effects.library import listed, of_kind
    from rwjax.effects.parameter import parameters

    return {name: parameters(effect) for name, effect in (of_kind(kind) if kind else listed()).items()}


def effects(leaves: dict[str, Any], kind: str) -> dict[str, dict[str, float]]:
    """The effects of a rig file, each with all its parameters.

    Args:
        leaves: Values by `effect.parameter`, an effect without parameters as `{}`.
        kind: Kind of the rig.

    Returns:
        Effect name -> parameter name -> value [SI, the parameter's unit].

    Raises:
        RigError: For an effect or a parameter that is unknown, a value of the wrong sign, a parameter left out.
    """
    if not leaves:
        return {}
    known = effect_parameters(kind)
    given: dict[str, dict[str, float]] = {}
    for key, value in leaves.items():
        name, _, parameter = (key, "", "") if value == {} else key.rpartition(".")
        if name not in known:
            near = nearest(name or key, known)
            raise RigError(f'no effect `{name or key}` for a `{kind}` rig; the nearest is [effects."{near}"]')
        parameters = given.setdefault(name, {})
        if parameter and parameter not in known[name]:
            wanted = ", ".join(f"`{p}`" for p in known[name])
            raise RigError(f"the effect `{name}` has no parameter `{parameter}`; it has {wanted}")
        if parameter:
            parameters[parameter] = parameter_value(f'effects."{name}".{parameter}', value, known[name][parameter])
    for name, parameters in given.items():
        parameters |= _left_out(name, parameters, known[name])
    return given


def parameter_value(key: str, value: Any, known: "Parameter") -> float:
    """A value that one of an effect's numbers may have.

    Args:
        key: Its name in messages.
        value: What the file holds.
        known: What is known of the number.

    Returns:
        The value [SI, the parameter's unit].

    Raises:
        RigError: For anything but a number within its bounds and the range of its unit.
    """
    low, high = known.bounds
    sign = "positive" if low > 0.0 else "zero or positive" if low == 0.0 else "any"
    found = number(key, value, sign)
    if not low <= found <= high:
        unit = "" if known.unit == "1" else f" {known.unit}"
        span = f"lies between {low:g} and {high:g}{unit}" if math.isfinite(high) else f"is {low:g}{unit} at least"
        raise RigError(f"`{key}` is {found!r}; it {span}")
    return number(key, found, "any" if math.isfinite(low + high) else sign, known.unit)


def rig_value(name: str, value: Any, key: str = "") -> float:
    """A value that a number of a rig may have, one of the plant's or of an effect's.

    Args:
        name: Name of the number.
        value: What a file says.
        key: What messages call it; "" for its name.

    Returns:
        The value [SI].

    Raises:
        RigError: For anything but a number of its sign and range.
    """
    if name in NUMBERS:
        return number(key or name, value, NUMBERS[name].sign, NUMBERS[name].unit)
    effect, _, parameter = name.rpartition(".")
    return parameter_value(key or name, value, effect_parameters()[effect][parameter])


def _left_out(name: str, given: dict[str, float], known: "dict[str, Parameter]") -> dict[str, float]:
    """The null values of the parameters that a file may leave out; `RigError` for any other that is missing."""
    found = {}
    for parameter in [p for p in known if p not in given]:
        if not known[parameter].optional:
            unit = known[parameter].unit
            raise RigError(f'no `{parameter}` ({unit}) for `{name}`; write {parameter} = … under [effects."{name}"]')
        found[parameter] = known[parameter].null
    return found
