"""The checks of a rig file: from parsed TOML to plain values; a mistake is a `RigError` with key and fix."""

import math
from collections.abc import Collection, Iterator
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

from rwjax.errors import RigError, nearest
from rwjax.kinds import COEFFICIENTS, ENCODERS, KEYS, KINDS, NUMBERS, POLYNOMIAL, SIGNS, THESIS_CHOICES

if TYPE_CHECKING:
    from rwjax.effects.parameter import Parameter


class Pwm(NamedTuple):
    """The map from a pulse width [us] to volts: `(pulse − neutral_us)·volts_per_us`."""

    neutral_us: float
    volts_per_us: float


def leaves(document: dict[str, Any]) -> dict[str, Any]:
    """Everything in the document that is not a table, by dotted name; an empty table counts as a leaf."""
    pairs = list(_pairs(document))
    for i, (key, _) in enumerate(pairs):
        if key in (earlier for earlier, _ in pairs[:i]):
            raise RigError(f"`{key}` is given twice; give it once")
    return dict(pairs)


def _pairs(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, dict) and value:
            yield from _pairs(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def take(leaves: dict[str, Any], section: str) -> dict[str, Any]:
    """Removes and returns the leaves below `section`, which is absent, empty or a table."""
    if leaves.pop(section, {}) != {}:
        raise RigError(f"`{section}` is not a table; write it as a section `[{section}]`")
    names = [key for key in leaves if key.startswith(section + ".")]
    return {key.removeprefix(section + "."): leaves.pop(key) for key in names}


def check_keys(leaves: dict[str, Any], kind: str) -> None:
    """`RigError` for the first key that is not of the interface, or not of this kind of rig."""
    for key, value in leaves.items():
        meant = [k for k in KEYS if k == key or (value == {} and k.startswith(key + "."))]
        if not meant:
            near = nearest(key, (k for k, kinds in KEYS.items() if kind in kinds))
            raise RigError(f"unknown key `{key}`; the nearest valid one is `{near}`")
        kinds = {k for m in meant for k in KEYS[m]}
        if kind not in kinds:
            right = " or ".join(f'"{k}"' for k in KINDS if k in kinds)
            raise RigError(f"`{key}` does not belong to a `{kind}` rig; take it out, or set kind = {right}")


def _number(key: str, value: Any, sign: str = "any", finite: bool = True) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise RigError(f"`{key}` is {value!r}; it has to be a number, such as 0.0182")
    number = float(value) if abs(value) < 1e300 or isinstance(value, float) else math.inf
    if math.isnan(number) or (finite and math.isinf(number)):
        raise RigError(f"`{key}` is {number}; it has to be a finite number")
    if not SIGNS[sign](number):
        raise RigError(f"`{key}` is {number!r}; it has to be {sign}")
    return number


def kind(leaves: dict[str, Any]) -> str:
    """Removes and returns `kind`."""
    found = leaves.pop("kind", None)
    if found not in KINDS:
        said = "no `kind`" if found is None else f"`kind` is {found!r}"
        raise RigError(f'{said}; write kind = "wheel", "platform", "reaction" or "two_axis"')
    return found


def numbers(leaves: dict[str, Any], kind: str) -> dict[str, float]:
    """The plant numbers, each of the right sign, and together enough for the kind."""
    given = {name: leaves[name] for name in NUMBERS if name in leaves}
    if POLYNOMIAL in leaves:
        if other := next((name for name in given if name.startswith("axis.friction.")), None):
            raise RigError(
                f"`{POLYNOMIAL}` is the whole friction, and `{other}` stands beside it; take one of them out"
            )
        coefficients = leaves[POLYNOMIAL]
        if not isinstance(coefficients, list) or len(coefficients) != len(COEFFICIENTS):
            raise RigError(f"`{POLYNOMIAL}` is {coefficients!r}; it has to be the four numbers [b3, b2, b1, b0]")
        given |= dict(zip(COEFFICIENTS, coefficients, strict=True))
    checked = {name: _number(name, value, NUMBERS[name].sign) for name, value in given.items()}
    _check_together(checked, kind)
    return checked


def _check_together(numbers: dict[str, float], kind: str) -> None:
    for name, n in NUMBERS.items():
        if n.required and kind in n.kinds and name not in numbers:
            section, _, key = name.rpartition(".")
            missing = f"no `{name}` ({n.symbol}, {n.unit}), which a `{kind}` rig needs"
            raise RigError(f"{missing}; write {key} = … under [{section}]")
    for axis, (key, needed) in product(
        ("axis", "yaw", "pitch"),
        (
            ("friction.static", "friction.stribeck_velocity"),
            ("friction.stribeck_velocity", "friction.static"),
            ("gravity.angle", "gravity.torque"),
        ),
    ):
        name, other = f"{axis}.{key}", f"{axis}.{needed}"
        if name in numbers and other not in numbers:
            raise RigError(f"`{name}` means nothing without `{other}`; give both, or neither")
    if kind == "two_axis":
        _check_inertia(numbers)


def _check_inertia(numbers: dict[str, float]) -> None:
    """`RigError` where a two-axis rig could turn and lose energy by it."""
    D, xy, xz, yz = (numbers.get(f"gimbal.{n}", 0.0) for n in ("difference", "product_xy", "product_xz", "product_yz"))
    for degrees in range(-180, 181):
        s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        A, P = numbers["yaw.inertia"] + D * s * s + 2.0 * xz * s * c, xy * s - yz * c
        if A <= 0.0 or A * numbers["pitch.inertia"] <= P * P:
            raise RigError(
                f"`[gimbal]` is too large for `yaw.inertia` and `pitch.inertia`: at a pitch of {degrees} deg the rig would "
                "have no positive inertia; no body has such a tensor, so make its numbers smaller"
            )


def effect_parameters(kind: str | None = None) -> "dict[str, dict[str, Parameter]]":
    """The parameters of every known effect, or of those that a kind may have. Imports JAX: called only where a file
    needs it."""
    from rwjax.effects.library import BY_NAME, of_kind
    from rwjax.effects.parameter import parameters

    return {name: parameters(effect) for name, effect in (of_kind(kind) if kind else BY_NAME).items()}


def effects(leaves: dict[str, Any], kind: str) -> dict[str, dict[str, float]]:
    """The effects of the file: name -> parameters, neither unknown nor missing."""
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
            low = known[name][parameter].bounds[0]
            sign = "positive" if low > 0.0 else "zero or positive" if low == 0.0 else "any"
            parameters[parameter] = _number(f'effects."{name}".{parameter}', value, sign)
    for name, parameters in given.items():
        for parameter in [p for p in known[name] if p not in parameters]:
            unit = known[name][parameter].unit
            if known[name][parameter].optional:
                parameters[parameter] = known[name][parameter].null
                continue
            raise RigError(f'no `{parameter}` ({unit}) for `{name}`; write {parameter} = … under [effects."{name}"]')
    return given


def text(leaves: dict[str, Any], key: str, default: str) -> str:
    value = leaves.get(key, default)
    if not isinstance(value, str):
        raise RigError(f'`{key}` is {value!r}; it has to be a text in quotes, "{value}"')
    return value


def pwm(leaves: dict[str, Any]) -> Pwm | None:
    given = {key: leaves[f"drive.pwm.{key}"] for key in Pwm._fields if f"drive.pwm.{key}" in leaves}
    if not given:
        return None
    if missing := next((key for key in Pwm._fields if key not in given), None):
        raise RigError(f"`drive.pwm` has no `{missing}`; write pwm = {{ neutral_us = 1500, volts_per_us = 0.02 }}")
    signs = {"neutral_us": "positive", "volts_per_us": "different from zero"}
    return Pwm(**{key: _number(f"drive.pwm.{key}", value, signs[key]) for key, value in given.items()})


def counts_per_rev(leaves: dict[str, Any]) -> dict[str, float]:
    """Counted edges per turn of each encoder by what it sits on, where given."""
    keys = {f"{section}.counts_per_rev": who for section, (who, _) in ENCODERS.items()}
    return {who: _number(key, leaves[key], "positive") for key, who in keys.items() if key in leaves}


def columns(leaves: dict[str, Any]) -> dict[str, str]:
    given = {key: leaves[f"columns.{key}"] for key in THESIS_CHOICES if f"columns.{key}" in leaves}
    for key, value in given.items():
        if value not in THESIS_CHOICES[key]:
            right = " or ".join(f'"{column}"' for column in THESIS_CHOICES[key])
            raise RigError(f"`columns.{key}` is {value!r}; it has to be {right}, a column of the thesis layout")
    return given


def names(leaves: dict[str, Any], key: str, values: dict[str, float], kind: str) -> tuple[str, ...]:
    """The names of numbers that `key` lists, the polynomial written out as its four coefficients."""
    given = leaves.get(key, [])
    if not isinstance(given, list) or not all(isinstance(name, str) for name in given):
        raise RigError(f'`{key}` is {given!r}; it has to be a list of names, such as ["axis.inertia"]')
    held: dict[str, tuple[str, ...]] = {name: (name,) for name in values}
    if COEFFICIENTS[0] in values:
        held[POLYNOMIAL] = COEFFICIENTS
    for name in given:
        check_held(name, held, key, kind)
    listed = tuple(each for name in given for each in held[name])
    if twice := next((name for i, name in enumerate(listed) if name in listed[:i]), None):
        raise RigError(f"`{key}` names `{twice}` twice; name it once")
    return listed


def per_run(leaves: dict[str, Any], free: tuple[str, ...], values: dict[str, float], kind: str) -> tuple[str, ...]:
    """The names in `fit.per_run`, all of them free."""
    listed = names(leaves, "fit.per_run", values, kind)
    if fixed := next((name for name in listed if name not in free), None):
        raise RigError(f"`fit.per_run` names `{fixed}`, which is not estimated; name it in `fit.free` too")
    if absent := next((name for name in listed if name.endswith(".inductance") and values[name] == 0.0), None):
        raise RigError(f"`fit.per_run` names `{absent}`, which is 0 and left out; give it a starting value")
    return listed


def check_held(name: str, held: Collection[str], where: str, kind: str) -> None:
    """`RigError` if the name that `where` uses has no value in the file."""
    if name in held:
        return
    numbers = [n for n, kinds in KEYS.items() if kind in kinds and (n in NUMBERS or n == POLYNOMIAL)]
    if name in numbers or name in {f"{e}.{p}" for e, known in effect_parameters().items() for p in known}:
        raise RigError(f"`{where}` names `{name}`, which has no value in this file; give it a starting value")
    raise RigError(f"`{where}` names `{name}`, no number of this file; the nearest is `{nearest(name, held)}`")


def bound(name: str, pair: Any, values: dict[str, float], kind: str) -> tuple[float, float]:
    check_held(name, values, "fit.bounds", kind)
    key = f"fit.bounds.{name}"
    if not isinstance(pair, list) or len(pair) != 2:
        raise RigError(f"`{key}` is {pair!r}; it has to be [lowest, highest]")
    low, high = (_number(key, value, finite=False) for value in pair)
    if not low < high:
        raise RigError(f"`{key}` is [{low!r}, {high!r}]; the first has to be below the second")
    if not low <= values[name] <= high:
        raise RigError(f"`{name}` is {values[name]!r}, outside its `fit.bounds` [{low!r}, {high!r}]; widen them")
    return low, high


def prior(name: str, pair: Any, free: tuple[str, ...], bounds: tuple[float, float]) -> tuple[float, float]:
    """Mean and standard deviation of what is known of a free number besides the logs."""
    key = f"fit.prior.{name}"
    if name not in free:
        raise RigError(f"`{key}` is of no use, since `{name}` is not estimated; name it in `fit.free`, or take it out")
    if not isinstance(pair, list) or len(pair) != 2:
        raise RigError(f"`{key}` is {pair!r}; it has to be [mean, standard deviation]")
    mean = _number(key, pair[0], NUMBERS[name].sign if name in NUMBERS else "any")
    if not bounds[0] <= mean <= bounds[1]:
        raise RigError(
            f"`{key}` has the mean {mean!r}, outside the number's `fit.bounds` [{bounds[0]!r}, {bounds[1]!r}]"
        )
    return mean, _number(key, pair[1], "positive")


def standard_error(name: str, value: Any, values: dict[str, float], kind: str) -> float:
    check_held(name, values, "fit.standard_error", kind)
    return _number(f"fit.standard_error.{name}", value, "zero or positive", finite=False)
