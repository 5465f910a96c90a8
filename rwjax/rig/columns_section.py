"""The section `[columns]` of a rig file: which column of a log file is which of rwjax's own, in which unit."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rwjax.errors import RigError, nearest, no_name
from rwjax.kinds import THESIS_CHOICES
from rwjax.rig.columns import COLUMNS, columns_of, unit_of
from rwjax.rig.document import number, shown
from rwjax.rig.units import factor

if TYPE_CHECKING:
    import numpy as np


class Source(NamedTuple):
    """A column of a log file that becomes one of rwjax's: `sign · scale · unit · (what the file holds − offset)`.

    Attributes:
        column: Its name in the file.
        unit: Its unit as text, "" where it is in that of rwjax's column.
        scale: What it is multiplied with, a number or a text with a unit ("12 V / 255").
        sign: 1, or -1 where the file counts the other way.
        offset: What the file holds at zero [as in the file].
        unsigned: Whether the device reports a size without its sign; it is compared with the size of the model's.
        factor: All that the file's number less the offset is multiplied with [SI unit per the file's].
    """

    column: str
    unit: str = ""
    scale: float | str = 1.0
    sign: int = 1
    offset: float = 0.0
    unsigned: bool = False
    factor: float = 1.0

    def convert(self, values: "np.ndarray") -> "np.ndarray":
        """The column in SI.

        Args:
            values: What the file holds `(n,)` [as in the file].

        Returns:
            Values `(n,)` [SI].
        """
        away = values - self.offset if self.offset else values
        parts = round(1.0 / self.factor) if abs(self.factor) < 1.0 else 0
        if parts and abs(parts * self.factor - 1.0) < 1e-12:
            return away / parts  # 7 ms are 0.007 s to the last digit
        return away * self.factor if self.factor != 1.0 else away


KEYS = Source._fields[:-1]
"""Keys of one column's table."""


def sources(given: Mapping[str, Any], kind: str) -> dict[str, Source]:
    """The columns of a log file by the names of rwjax's columns that they become.

    Args:
        given: Values of the section by the rest of their dotted name, without those of the thesis's layout.
        kind: Kind of the rig.

    Returns:
        Sources by name, in the order of the file.

    Raises:
        RigError: For a name that no log of this kind has, for an unknown key, and for values that cannot be.
    """
    tables: dict[str, dict[str, Any]] = {}
    valid = columns_of(kind)
    for name, value in given.items():
        column, _, key = name.partition(".")
        if column not in valid:
            near = nearest(column, (*valid, *THESIS_CHOICES))
            raise RigError(
                f"unknown key `columns.{column}`; the nearest valid one of a `{kind}` rig is `columns.{near}`"
            )
        table = tables.setdefault(column, {})
        if key or value == {}:
            table |= {key: value} if key else {}
        elif isinstance(value, str):
            table["column"] = value
        else:
            raise RigError(
                f'`columns.{column}` is {shown(value)}; write {column} = "NAME" or {{ column = "NAME", unit = "…" }}'
            )
    return {column: _source(column, table, kind) for column, table in tables.items()}


def _source(name: str, table: dict[str, Any], kind: str) -> Source:
    """One column's table, checked."""
    key = f"columns.{name}"
    if unknown := next((k for k in table if k not in KEYS), None):
        raise RigError(f"unknown key `{key}.{unknown}`; the nearest valid one is `{key}.{nearest(unknown, KEYS)}`")
    column, unit = (_text(f"{key}.{k}", table.get(k, default)) for k, default in (("column", name), ("unit", "")))
    scale = table.get("scale", 1.0)
    scale = (
        _text(f"{key}.scale", scale) if isinstance(scale, str) else number(f"{key}.scale", scale, "different from zero")
    )
    if (sign := table.get("sign", 1)) not in (1, -1) or isinstance(sign, bool):
        raise RigError(f"`{key}.sign` is {shown(sign)}; it has to be 1 or -1")
    unsigned = table.get("unsigned", False)
    if not isinstance(unsigned, bool):
        raise RigError(f"`{key}.unsigned` is {shown(unsigned)}; it has to be true or false")
    if unsigned and not (name in COLUMNS and name.endswith(("_rad_s", "_A"))):
        raise RigError(f"`{key}.unsigned`: only a measured rate or current may lack its sign; take it out")
    offset = number(f"{key}.offset", table.get("offset", 0.0))
    if abs(offset) > 1e15:
        raise RigError(f"`{key}.offset` is {offset!r}; it lies between -1e+15 and 1e+15")
    to = "" if name.endswith("_counts") else unit_of(name)
    try:
        total = int(sign) * factor(scale, unit, to, kind == "platform")
    except ValueError as error:
        said = f'`{key}.unit` "{unit}"' if unit else f"`{key}.scale` {shown(scale)}"
        raise RigError(f"{said} {error}") from None
    return Source(column, unit, scale, int(sign), offset, unsigned, total)


def _text(key: str, value: Any) -> str:
    """A text on one line."""
    if not isinstance(value, str):
        raise RigError(f"`{key}` is {shown(value)}; it has to be a text in quotes")
    if wrong := no_name(value):
        raise RigError(f"`{key}` {wrong}")
    return value


def entry(name: str, source: Source) -> str | dict[str, Any]:
    """What stands in a rig file for a source.

    Args:
        name: The column of rwjax's that it becomes.
        source: The source.

    Returns:
        The column's name where it says all, else the keys that differ from what they are by default.
    """
    default = Source(name)
    keys = {key: value for key in KEYS if (value := getattr(source, key)) != getattr(default, key)}
    return source.column if set(keys) <= {"column"} else keys
