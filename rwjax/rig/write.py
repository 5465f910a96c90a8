"""Rig files (TOML) written: a `Rig` as text that reads back as an equal one."""

from collections.abc import Iterator
from typing import Any

import tomlkit
from tomlkit.items import InlineTable

from rwjax.errors import RigError, refuses_other_types
from rwjax.kinds import COEFFICIENTS, ENCODERS, HALVES, NUMBERS, POLYNOMIAL, SERVO, encoder_section, unit_in_servo
from rwjax.rig.columns_section import entry
from rwjax.rig.effect_section import effect_parameters
from rwjax.rig.model import CAUTION, GUESS, Rig
from rwjax.rig.read import parse_rig

_ORDER = (
    "kind",
    "name",
    "motor",
    "gear",
    "wheel",
    "drive",
    "axis",
    *(own for half in HALVES for own in half.values()),
    "gimbal",
    *ENCODERS,
    "columns",
    "fit",
    "effects",
)
"""Sections and keys at the top of the file, in their order."""


@refuses_other_types
def write_rig(rig: Rig) -> str:
    """A rig as the text of a rig file, with units in comments.

    Args:
        rig: Any rig.

    Returns:
        TOML text, from which `parse_rig` makes an equal rig.

    Raises:
        RigError: Where the reader would refuse it: a number of the rig is not finite, or lies outside its range or bounds.
        InputError: The argument is no rig.
    """
    text = _text(rig)
    try:
        parse_rig(text)
    except RigError as error:
        what = str(error).removeprefix("rig.toml: ")
        raise RigError(f"rig `{rig.name}` cannot be written, since no rig file may say so: {what}") from None
    return text


def _text(rig: Rig) -> str:
    """A rig as the text of a rig file, whatever its numbers are."""
    document = tomlkit.document()
    for caution in rig.cautions:
        document.add(tomlkit.comment(f"{CAUTION}{caution}"))
    for path, value, comment in sorted(_entries(rig), key=lambda entry: _ORDER.index(entry[0][0])):
        table: Any = document
        for section in path[:-1]:
            table = table.setdefault(section, tomlkit.table())
        if ".".join(path).removeprefix("effects.") in rig.guessed:
            comment = f"{comment}: {GUESS}" if comment else GUESS
        item = _inline(value) if isinstance(value, dict) else tomlkit.item(value)
        table.add(path[-1], item.comment(comment) if comment else item)
    return tomlkit.dumps(document)


def _inline(values: dict[str, Any]) -> InlineTable:
    """A table on one line."""
    table = tomlkit.inline_table()
    table.update(values)
    return table


def _entries(rig: Rig) -> Iterator[tuple[tuple[str, ...], Any, str]]:
    """Path, value and comment of everything in the file; inside a section in the order of the file."""
    yield ("kind",), rig.kind, ""
    yield ("name",), rig.name, ""
    for name in (n for n in NUMBERS if n in rig.numbers and n not in COEFFICIENTS):
        unit = unit_in_servo(name, rig.servo.acts_on) if rig.servo is not None else NUMBERS[name].unit
        yield tuple(name.split(".")), rig.numbers[name], f"{NUMBERS[name].symbol}, {unit}"
    if COEFFICIENTS[0] in rig.numbers:
        coefficients = [rig.numbers[name] for name in COEFFICIENTS]
        yield (
            tuple(POLYNOMIAL.split(".")),
            coefficients,
            "b3, b2, b1, b0; N m over |w|^0 to |w|^3, w in rad/s",
        )
    if rig.servo is not None:
        for key, word in rig.servo._asdict().items():
            yield (*SERVO.split("."), key), word, ""
    if rig.pwm is not None:
        yield ("drive", "pwm"), rig.pwm._asdict(), "us, V/us"
    for who, counts in rig.counts_per_rev.items():
        whole = int(counts) if counts.is_integer() else counts
        yield (encoder_section(who, rig.kind), "counts_per_rev"), whole, "edges per turn"
    for key, column in rig.columns.items():
        yield ("columns", key), column, ""
    for name, source in rig.sources.items():
        yield ("columns", name), entry(name, source), ""
    if rig.free:
        yield ("fit", "free"), _folded(rig.free), ""
    if rig.per_run:
        yield ("fit", "per_run"), _folded(rig.per_run), "a value for each log"
    for name, formula in rig.tied.items():
        yield ("fit", "tied", name), formula, ""
    for name, (mean, spread) in rig.prior.items():
        yield ("fit", "prior", name), [mean, spread], "mean, standard deviation"
    for name, error in rig.standard_error.items():
        yield ("fit", "standard_error", name), error, ""
    for name, bounds in rig.bounds.items():
        yield ("fit", "bounds", name), list(bounds), ""
    units = effect_parameters() if rig.effects else {}
    for effect, parameters in rig.effects.items():
        for parameter, value in parameters.items():
            yield ("effects", effect, parameter), value, units[effect][parameter].unit


def _folded(free: tuple[str, ...]) -> list[str]:
    """`free` with the four coefficients, where they stand in a row, under their one name in the file."""
    n = len(COEFFICIENTS)
    rows = (i for i in range(len(free)) if free[i : i + n] == COEFFICIENTS)
    i = next(rows, None)
    return list(free) if i is None else [*free[:i], POLYNOMIAL, *free[i + n :]]
