"""Units that a user writes in words (`deg`, `rpm`, `12 V / 255`), as factors to SI: the library pint reads them."""

import math
import re
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pint

LONGEST = 60
"""Characters of a unit."""
_ALLOWED = re.compile(r"[a-zA-Z0-9_\s.*/()+\-°%µμΩ]*")
"""What a unit is written with; powers of powers of numbers take for ever to work out, and no column needs one."""
_LENGTHS = {"rad": "m", "rad/s": "m/s"}
"""Unit of a linear axis that stands for one of a turning axis."""
EXAMPLES = {
    "s": "s, ms or us",
    "V": "V or mV",
    "A": "A or mA",
    "rad": "rad, deg or turn",
    "rad/s": "rad/s, deg/s or rpm",
    "N m": "N m or mN m",
    "m": "m or mm",
    "": "percent, or none",
}
"""What may stand for a unit, by the SI unit that it becomes."""


def factor(scale: float | str, unit: str, to: str, linear: bool = False) -> float:
    """What a file's number is multiplied with to be in SI.

    Args:
        scale: A number [1], or a text of one with or without a unit ("12 V / 255").
        unit: Unit of the file's number, which the scale is multiplied with; "" for none.
        to: SI unit of the quantity, a key of `EXAMPLES`.
        linear: Whether a length may stand for an angle, on a linear axis.

    Returns:
        The factor [SI unit per the file's]; where neither text holds a unit, the scale as it is.

    Raises:
        ValueError: Where a text is no unit, or one of another quantity, with what would be right.
    """
    if not unit and not isinstance(scale, str):
        return _usable(float(scale), f"{scale}")
    said = " ".join(str(part) for part in (scale, unit) if part not in ("", 1.0))
    quantity = (_read(scale) if isinstance(scale, str) else scale) * (_read(unit) if unit else 1.0)
    if isinstance(quantity, int | float):
        return _usable(float(quantity), said)
    base = quantity.to_base_units()
    value, of = _usable(float(base.magnitude), said), str(base.units)
    if of in ("dimensionless", "count") and (not to or not unit):
        return value
    wanted = [to, *([_LENGTHS[to]] if linear and to in _LENGTHS else [])]
    if not any(each and of == str(_registry()(each).to_base_units().units) for each in wanted):
        turns = (
            "; of turns a second write turn/s, of turns a minute rpm" if to == "rad/s" and of == "1 / second" else ""
        )
        raise ValueError(f"is no unit of this column; write {EXAMPLES[to]}{turns}")
    return value


def _usable(value: float, said: str) -> float:
    """A factor that is neither 0 nor without end."""
    if not math.isfinite(value) or not 1e-30 < abs(value) < 1e30:
        raise ValueError(f"makes {value:g} of {said}; it has to be a finite number other than 0")
    return value


def _read(text: str) -> Any:
    """A number with its unit, of pint, or a number alone."""
    if len(text) > LONGEST or not _ALLOWED.fullmatch(text) or "**" in text:
        raise ValueError("is no unit; write one such as ms, deg, rpm, mA or 12 V / 255")
    text = re.sub(r"\b(m|k|c)?Nm\b", r"\1N m", text)  # as everybody writes it
    try:
        return 1.0 * _registry().parse_expression(text)
    except Exception:  # pint's parser raises what its steps raise, of a dozen kinds
        raise ValueError("is no unit that is known; write one such as ms, deg, rpm, mA or 12 V / 255") from None


@cache
def _registry() -> "pint.UnitRegistry":
    """The units, with the first rig file that names one: they take a third of a second."""
    import pint

    registry = pint.UnitRegistry()
    registry.define("@alias turn = rev")
    return registry
