"""A rig file's parsed TOML as values by dotted name, and the checks that every value goes through."""

import math
from collections.abc import Iterator
from typing import Any

from rwjax.errors import RigError, nearest, no_name
from rwjax.kinds import KEYS, KINDS, SIGNS, beyond


def leaves(document: dict[str, Any]) -> dict[str, Any]:
    """Every value of a document that is not a table, by its dotted name.

    Args:
        document: Parsed TOML, tables within tables.

    Returns:
        Values by name (`axis.inertia`), in the order of the file; an empty table counts as a value, `{}`.

    Raises:
        RigError: Where a name is given twice, once quoted and once by its section.
    """
    found: dict[str, Any] = {}
    for key, value in _pairs(document):
        if key in found:
            raise RigError(f"`{key}` is given twice; give it once")
        found[key] = value
    return found


def _pairs(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, dict) and value:
            yield from _pairs(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def take(leaves: dict[str, Any], section: str) -> dict[str, Any]:
    """Moves what stands below a section out of a document's values.

    Args:
        leaves: Values by dotted name; those of the section are removed.
        section: Name of the section, which may be absent or empty.

    Returns:
        The section's values, by the rest of their name.

    Raises:
        RigError: Where the section is a value and no table.
    """
    if leaves.pop(section, {}) != {}:
        raise RigError(f"`{section}` is not a table; write it as a section `[{section}]`")
    names = [key for key in leaves if key.startswith(section + ".")]
    return {key.removeprefix(section + "."): leaves.pop(key) for key in names}


def check_keys(leaves: dict[str, Any], kind: str) -> None:
    """Checks that every key is one of the rig file's and belongs to the kind of rig.

    Args:
        leaves: Values by dotted name.
        kind: Kind of the rig.

    Raises:
        RigError: For the first key that is unknown, or of another kind.
    """
    for key, value in leaves.items():
        meant = [k for k in KEYS if k == key or (value == {} and k.startswith(key + "."))]
        if not meant:
            near = nearest(key, (k for k, kinds in KEYS.items() if kind in kinds))
            raise RigError(f"unknown key `{key}`; the nearest valid one is `{near}`")
        kinds = {k for m in meant for k in KEYS[m]}
        if kind not in kinds:
            right = " or ".join(f'"{k}"' for k in KINDS if k in kinds)
            raise RigError(f"`{key}` does not belong to a `{kind}` rig; take it out, or set kind = {right}")


def shown(value: Any) -> str:
    """A value of the file as messages show it.

    Args:
        value: What the file holds.

    Returns:
        The value as text.
    """
    try:
        return repr(value)
    except ValueError:  # Python writes no whole number of more than some thousand digits
        return "a number of thousands of digits"


def number(key: str, value: Any, sign: str = "any", unit: str = "", finite: bool = True) -> float:
    """A value of the file as a number.

    Args:
        key: Its name in messages.
        value: What the file holds.
        sign: What sign it has to have, a key of `kinds.SIGNS`.
        unit: Unit in whose range (`kinds.RANGES`) it has to lie; "" for no range.
        finite: Whether it has to be finite.

    Returns:
        The number [SI, as in the file]; whole numbers beyond 1e300 become infinite.

    Raises:
        RigError: For anything but a number of this sign in this range.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise RigError(f"`{key}` is {shown(value)}; it has to be a number, such as 0.0182")
    found = float(value) if abs(value) < 1e300 or isinstance(value, float) else math.inf
    if math.isnan(found) or (finite and math.isinf(found)):
        raise RigError(f"`{key}` is {found}; it has to be a finite number")
    if not SIGNS[sign](found):
        raise RigError(f"`{key}` is {found!r}; it has to be {sign}")
    if unit and (limits := beyond(found, unit, sign)):
        raise RigError(f"`{key}` is {found!r}; {limits}")
    return found


def text(leaves: dict[str, Any], key: str, default: str) -> str:
    """A text of the file, which stands on one line and names something.

    Args:
        leaves: Values by dotted name.
        key: Name of the text.
        default: The text where the file holds none.

    Returns:
        The text.

    Raises:
        RigError: Where the value is no text, holds a character that is not printed, or is too long for a name.
    """
    value = leaves.get(key, default)
    if not isinstance(value, str):
        raise RigError(f'`{key}` is {shown(value)}; it has to be a text in quotes, "{shown(value)}"')
    if wrong := no_name(value):
        raise RigError(f"`{key}` {wrong}")
    return value
