"""Log files (CSV) written: columns and notes, so that every number reads back equal."""

import os
from collections.abc import Mapping

import numpy as np

from rwjax.errors import LogError, printable, refuses_other_types
from rwjax.logs.mapped_sheet import LAYOUT
from rwjax.logs.sheet import FREE_TEXT, ROLES
from rwjax.text_files import write_text


@refuses_other_types
def write_log(
    path: str | os.PathLike[str], columns: Mapping[str, np.ndarray], notes: Mapping[str, str] | None = None
) -> None:
    """Writes a log file, whole or not at all.

    Args:
        path: The file; one that is there is replaced.
        columns: Columns (n,) by rwjax's names, in the units of these; NaN becomes an empty cell.
        notes: Notes above the header by key, each on one line, below the note `layout`, which is the writer's own.

    Raises:
        LogError: Where the file cannot be written, and where a number is infinite: nothing is written then.
        ValueError: Where the columns differ in length, and for a name of a column or a key of a note that does not read back.
    """
    write_text(path, log_text(columns, notes, path), LogError)


def log_text(columns: Mapping[str, np.ndarray], notes: Mapping[str, str] | None, path: str | os.PathLike[str]) -> str:
    """What `write_log` writes.

    Args:
        columns: As `write_log`.
        notes: As `write_log`.
        path: What messages call the file.

    Returns:
        The text of the file.

    Raises:
        LogError: As `write_log`, for an infinite number and for a note that reads as a role.
        ValueError: As `write_log`.
    """
    for name in columns:
        _check_word(name, ",")
    for name, column in columns.items():
        if np.isinf(np.asarray(column, float)).any():
            raise LogError(f"{path}: not written, since `{name}` is not finite: check the rig's numbers")
    others = [(key, value) for key, value in (notes or {}).items() if key.lower() != LAYOUT[0]]
    head = [_note(key, value) for key, value in (LAYOUT, *others)]
    cells = [["" if x != x else repr(x) for x in np.asarray(column).tolist()] for column in columns.values()]
    rows = [",".join(row) for row in zip(*cells, strict=True)]
    return "\n".join([*head, ",".join(columns), *rows, ""])


def _note(key: str, value: str) -> str:
    """The one line of a note; what is not printed in its value, a line break above all, stands there as its escape."""
    _check_word(key, ":")
    if value.strip().lower() in ROLES and key.lower() not in ("role", *FREE_TEXT):
        raise LogError(
            f"the note `{key}: {value}` reads as a role; write `role: {value.strip().lower()}`, or other words"
        )
    return f"# {key}: {printable(value)}".rstrip()


def _check_word(word: str, separator: str) -> None:
    """`ValueError` for a name of a column or a key that the reader would take for something else."""
    if not word or not word.isprintable() or separator in word or word != word.strip() or word.startswith("#"):
        raise ValueError(
            f"{word!r}: a column's name and a note's key are printed, without {separator!r}, # and blanks around"
        )
