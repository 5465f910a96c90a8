"""The tables of effects and of ranges in `docs/files.md`: `python -m rwjax.effects.table` writes them from the code."""

import re
import sys
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

from rwjax.effects.effect import Effect
from rwjax.effects.library import EFFECTS, ON_TWO_AXES
from rwjax.effects.parameter import Parameter, parameters
from rwjax.kinds import ONE_AXIS, RANGES, SUBSYSTEMS

PAGE = Path("docs") / "files.md"
"""The page, from the root of the repository."""
ONLY_ON_TWO_AXES = tuple(effect for effect in ON_TWO_AXES if effect.__base__ not in EFFECTS)
REGIONS = {"effects": EFFECTS, "effects of two axes": ONLY_ON_TWO_AXES}
"""Effects of each table by the name between its markers."""
RANGES_REGION = "ranges"
"""The name between the markers of the table of ranges."""


def table(effects: Iterable[type[Effect]]) -> str:
    """A Markdown table of effects.

    Args:
        effects: The effects, a row each.

    Returns:
        The lines of the table.
    """
    rows = [("effect", "meaning", "equation", "numbers", "kinds"), ("---",) * 5, *map(_row, effects)]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def table_of_ranges() -> str:
    """A Markdown table of the sizes that quantities may have, a row for each unit.

    Returns:
        The lines of the table.
    """
    rows = [("quantity", "unit", "least", "most"), ("---",) * 4]
    rows += [(known.quantity, unit, f"{known.least:g}", f"{known.most:g}") for unit, known in RANGES.items()]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def with_tables(page: str) -> str:
    """The page with its tables written anew.

    Args:
        page: Text with a line `<!-- NAME -->` before and `<!-- /NAME -->` after each of the tables `REGIONS` and that of
            the ranges.

    Returns:
        The text with the tables of the library between these lines.

    Raises:
        ValueError: A marker is missing.
    """
    tables = {name: table(effects) for name, effects in REGIONS.items()} | {RANGES_REGION: table_of_ranges()}
    for name, lines in tables.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->\n"
        if not page.partition(begin)[2].partition(end)[1]:
            raise ValueError(f"no lines `{begin.strip()}` and `{end.strip()}`; put them around the place of the table")
        before, _, rest = page.partition(begin)
        page = f"{before}{begin}{lines}{end}{rest.partition(end)[2]}"
    return page


def _row(effect: type[Effect]) -> tuple[str, ...]:
    """The cells of an effect's row."""
    kinds = SUBSYSTEMS[effect.name.partition(".")[0]]
    where = "all" if {*ONE_AXIS} <= {*kinds} else ", ".join(kinds)
    return f"`{effect.name}`", effect.meaning or effect.label, effect.equation, _numbers(effect), where


def _numbers(effect: type[Effect]) -> str:
    """The numbers of an effect with their units; behind those that a file may leave out what they are then."""

    def said(p: Parameter) -> str:
        unit = re.sub(r"(?<=[A-Za-z])[23]", lambda found: {"2": "²", "3": "³"}[found[0]], p.unit)
        return f" {unit} ({p.null:g} if left out)" if p.optional else f" {unit}"

    groups = groupby(parameters(effect).values(), key=said)
    return ", ".join(", ".join(f"`{p.name}`" for p in same) + words for words, same in groups)


def main() -> None:
    """Writes the tables of `PAGE` in the current folder anew.

    Raises:
        SystemExit: There is no such page.
    """
    if not PAGE.exists():
        sys.exit(f"{PAGE}: is not below this folder; run this at the root of the repository")
    before = PAGE.read_text(encoding="utf-8")
    after = with_tables(before)
    PAGE.write_text(after, encoding="utf-8")
    print(f"{PAGE}: {'as it was' if after == before else 'written'}", file=sys.stderr)


if __name__ == "__main__":
    main()
