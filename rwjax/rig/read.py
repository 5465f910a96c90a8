"""Rig files (TOML) read: from the text to a checked `Rig`, every mistake as a `RigError` with file, key and remedy."""

import os
import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import Any

from rwjax.errors import LONGEST_TEXT, RigError, printable, refuses_other_types
from rwjax.kinds import COEFFICIENTS, NUMBERS, POLYNOMIAL, THESIS_CHOICES
from rwjax.rig import document, parse
from rwjax.rig.columns_section import sources
from rwjax.rig.effect_section import effects
from rwjax.rig.fit_section import FitTables, fit_section
from rwjax.rig.model import CAUTION, GUESS, Rig, with_one_axis
from rwjax.rig.tied import tied_section, with_tied
from rwjax.text_files import parse_toml, read_text


@refuses_other_types
def read_rig(path: str | os.PathLike[str]) -> Rig:
    """The rig that a TOML file describes.

    Args:
        path: The file.

    Returns:
        The rig, checked.

    Raises:
        RigError: With file, key, what is wrong and what would be right.
    """
    return parse_rig(read_text(path, RigError), path)


@refuses_other_types
def read_one_axis_rig(path: str | os.PathLike[str]) -> Rig:
    """The rig that a TOML file describes, for what knows one command and one axis.

    Args:
        path: The file.

    Returns:
        The rig, checked.

    Raises:
        RigError: As `read_rig`, and for a rig with two axes.
    """
    rig = read_rig(path)
    try:
        return with_one_axis(rig)
    except RigError as error:
        raise RigError(f"{path}: {error}") from None


@refuses_other_types
def parse_rig(text: str, path: str | os.PathLike[str] = "rig.toml") -> Rig:
    """The rig that a TOML text describes.

    Args:
        text: The text.
        path: What messages call the file; its stem names a rig without a name.

    Returns:
        The rig, checked.

    Raises:
        RigError: With file, key, what is wrong and what would be right.
    """
    try:
        rig = _rig(parse_toml(text), printable(Path(path).stem)[:LONGEST_TEXT])
        return replace(rig, cautions=tuple(_cautions(text)), guessed=tuple(_guessed(text)))
    except RigError as error:
        raise RigError(f"{path}: {error}") from None
    except ValueError as error:
        line = re.search(r"at line (\d+)", str(error))
        where = f"{path}:{line[1]}" if line else f"{path}"
        lines = text.split("\n")
        number = int(line[1]) if line else len(lines)  # else "at end of document"
        if twice := _given_twice(lines, lines[number - 1], str(error)):
            raise RigError(f"{path}:{number}: not valid TOML: {twice}") from None
        remedy = _remedy(lines[int(line[1]) - 1] if line and "after a statement" in str(error) else "", path)
        raise RigError(f"{where}: not valid TOML: {error}; {remedy}") from None


def _cautions(text: str) -> Iterator[str]:
    """What the comments above the first key of a rig file say that a diagnosis was not sure of."""
    for line in takewhile(lambda line: not line.strip() or line.startswith("#"), text.splitlines()):
        if line.startswith(mark := f"# {CAUTION}"):
            yield printable(line.removeprefix(mark))


def _guessed(text: str) -> Iterator[str]:
    """Dotted names of the keys that a comment behind them calls a guess."""
    section = ""
    for line in text.splitlines():
        if header := re.match(r"\s*\[([\w.\s\"'-]+)\]", line):  # as of `[effects."drive.deadzone"]`
            section = re.sub(r"[^\w.-]", "", header[1]).removeprefix("effects.") + "."
        elif key := re.match(rf"\s*([\w.]+)\s*=[^#]*#(?:.*[:,])?\s*{GUESS}\b", line):
            yield f"{section}{key[1]}"


def _given_twice(lines: list[str], line: str, error: str) -> str:
    """What is wrong with a line that says again what one above it has said; "" where that is not what is wrong."""
    if "Cannot overwrite" in error and (key := re.match(r"\s*([\w.-]+)\s*=", line)):
        return f"`{key[1]}` is given twice in this section; keep one of the lines"
    if "Cannot declare" in error and [each.strip() for each in lines].count(line.strip()) > 1:
        return f"`{printable(line.strip())}` stands twice; put all its keys under one such header"
    return ""


def _remedy(line: str, path: str | os.PathLike[str]) -> str:
    """What would be right instead of a line that is no TOML."""
    line = line[:200]  # a number ends before, and the patterns take long on digits without end
    if Path(path).suffix.lower() == ".csv":
        return "the rig file comes first, then the logs"
    if re.search(r"=\s*[-+]?\d+,\d", line):
        return "a number has no comma: decimals take a point (0.06), thousands nothing (4096)"
    if re.search(r"=\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(?![\deE.])\s*[a-zA-Z%°µΩ\[]", line):
        return "a unit does not stand in the file, all numbers are in SI (0.06 # kg m2); a text stands in quotes"
    return "write `key = value` under `[section]` headers"


def _rig(parsed: dict[str, Any], stem: str) -> Rig:
    """The rig of parsed TOML; `stem` of the file is its name where the file gives none."""
    leaves = document.leaves(parsed)
    kind = parse.kind(leaves)
    tables = FitTables(*(document.take(leaves, f"fit.{name}") for name in FitTables._fields))
    given = document.take(leaves, "effects")
    columns = document.take(leaves, "columns")
    leaves |= {f"columns.{key}": columns.pop(key) for key in THESIS_CHOICES if key in columns}
    document.check_keys(leaves, kind)
    tied = _tied(leaves, given, tables.tied, kind)
    rig = Rig(
        kind=kind,
        name=document.text(leaves, "name", stem),
        numbers=parse.numbers(leaves, kind),
        effects=effects(given, kind),
        counts_per_rev=parse.counts_per_rev(leaves),
        pwm=parse.pwm(leaves),
        columns=parse.columns(leaves),
        servo=parse.servo(leaves),
        sources=sources(columns, kind),
        tied=tied,
    )
    return replace(rig, **fit_section(leaves, tables, rig.values, kind)._asdict())


def _tied(leaves: dict[str, Any], given: dict[str, Any], table: dict[str, Any], kind: str) -> dict[str, str]:
    """The formulas of `[fit.tied]`, whose results take their places among the file's numbers and those of its effects."""
    if not table:
        return {}
    polynomial = leaves.get(POLYNOMIAL)
    stated = {name: leaves[name] for name in NUMBERS if name in leaves}
    if isinstance(polynomial, list) and len(polynomial) == len(COEFFICIENTS):
        stated |= dict(zip(COEFFICIENTS, polynomial, strict=True))
    of_effects = {f"{key}." if value == {} else key: value for key, value in given.items()}
    formulas, found = tied_section(stated | of_effects, table, kind)
    with_tied(leaves, {name: value for name, value in found.items() if name in NUMBERS})
    with_tied(given, {name: value for name, value in found.items() if name not in NUMBERS})
    return formulas
