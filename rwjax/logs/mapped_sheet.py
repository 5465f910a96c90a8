"""A table by the names of rwjax's columns, as `[columns]` of the rig file says which of the file's they are."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.errors import alike, nearest
from rwjax.logs.propose import is_asked_for
from rwjax.logs.sheet import Sheet
from rwjax.rig.columns import COMMANDS
from rwjax.rig.columns_section import Source

LAYOUT = ("layout", "rwjax")
"""Key and value of the note of a file whose columns are rwjax's already, so that `[columns]` does not count for it."""


@dataclass(frozen=True, eq=False)
class MappedSheet(Sheet):
    """A table by the names of rwjax's columns.

    Attributes:
        path: The file, or the name of what is no file.
        notes: Notes by key in small letters.
        names: Names of rwjax's columns that it has.
        of: The table as the file holds it.
        sources: Its columns by the names of rwjax's that they become.
    """

    of: Sheet
    sources: Mapping[str, Source]

    def where(self, row: int | None) -> str:
        """File and place of a row.

        Args:
            row: Index of the row, counted from 0; None for the names of the columns.

        Returns:
            What a message begins with, such as `run.csv:5`.
        """
        return self.of.where(row)

    def numbers(self, names: Sequence[str], dates: Collection[str] = ()) -> list[np.ndarray]:
        """Columns in the units of rwjax's names.

        Args:
            names: Names of rwjax's columns.
            dates: Those of them that may hold dates, where their numbers are in the unit of rwjax's name already.

        Returns:
            One array (n,) for each name [the unit in its name], NaN where there is no value.

        Raises:
            LogError: As the table.
        """
        used = [self.sources.get(name, Source(name)) for name in names]
        plain = [
            source.column
            for name, source in zip(names, used, strict=True)
            if name in dates and source.factor == 1.0 and not source.offset
        ]
        found = self.of.numbers([source.column for source in used], plain)
        return [source.convert(values) for source, values in zip(used, found, strict=True)]

    def called(self, name: str) -> str:
        """A column as messages call it.

        Args:
            name: Name of rwjax's column.

        Returns:
            The name in quotes, with the file's own where that is another.
        """
        source = self.sources.get(name, Source(name))
        return f"`{name}`" if source == Source(name) else f"`{name}` (column `{source.column}`)"


def mapped(
    sheet: Sheet, sources: Mapping[str, Source], valid: Sequence[str], left_out: Collection[str] = ()
) -> MappedSheet:
    """A table by the names of rwjax's columns.

    Args:
        sheet: The table as the file holds it.
        sources: The section `[columns]` of the rig file.
        valid: Columns that a log of this kind of rig may hold.
        left_out: Columns of the file that are left out.

    Returns:
        The table of those columns that `[columns]` names and of the others that go by rwjax's names; all else is passed over.

    Raises:
        LogError: For a column that `[columns]` names and the file lacks, though it holds one of rwjax's name, but for a command
            beside another one; and for one that the file has twice.
    """
    names = [name for name in sheet.names if name not in left_out]
    sources = {name: source for name, source in sources.items() if source.column not in left_out}
    held = {name: source for name, source in sources.items() if source.column in names}
    named = {source.column for source in held.values()}  # degrees under `yaw_counts` are no counts besides
    own = [name for name in valid if name in names and name not in held and name not in named]
    for column in (*(source.column for source in held.values()), *own):
        if names.count(column) > 1:
            raise sheet.error(
                None, f"column `{column}` is there {names.count(column)} times; rename or leave out others"
            )
    given = {*held, *own}
    commanded = any(name in COMMANDS for name in given)
    for name, source in sources.items():
        if name in held or (commanded and name in COMMANDS and name not in own):
            continue
        found = ", ".join(f"`{each}`" for each in sheet.names[:30])
        used = {other.column for other in sources.values()}
        free = [each for each in sheet.names if each not in used and (name in COMMANDS or not is_asked_for(each))]
        near = f", nearest `{nearest(source.column, free)}`" if alike(source.column, free) else ""
        raise sheet.error(None, f"no column `{source.column}`, which [columns] names for `{name}`; found {found}{near}")
    return MappedSheet(sheet.path, sheet.notes, [name for name in valid if name in given], sheet, held)
