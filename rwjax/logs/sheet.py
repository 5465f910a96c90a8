"""A log file as text: notes, header, rows, and columns as numbers. What the columns mean is in `layouts.py`."""

import math
import os
from typing import NamedTuple

import numpy as np

from rwjax.errors import LogError
from rwjax.kinds import RANGES, THESIS_COLUMNS
from rwjax.text_files import read_text

FEWEST = 10
"""Samples of a log, and readings of a column, below which nothing can be said."""

MOST_COLUMNS = 1000
"""Columns of a log: a header of more is no header."""
ROLES = ("train", "validate")
"""What the note `role` may say: a log is for the fit, or to judge what was fitted."""
FREE_TEXT = ("run", "why", "rig")
"""Keys of notes that name or say something in any words, such as a run that is called `validate`."""


class Sheet(NamedTuple):
    """A log file as text.

    Attributes:
        path: The file.
        notes: Lines `# key: value` above the header, by key in small letters.
        header: Line number of the header, counted from 1.
        names: Names of the columns.
        delimiter: What separates the cells of a row.
        rows: The lines below the header.
    """

    path: str | os.PathLike[str]
    notes: dict[str, str]
    header: int
    names: list[str]
    delimiter: str
    rows: list[str]

    def error(self, row: int | None, message: str) -> LogError:
        """An error that names the file and the line.

        Args:
            row: Index of the row that is wrong, counted from 0; None for the header.
            message: What is wrong and what would be right.

        Returns:
            The error, to be raised.
        """
        return LogError(f"{self.path}:{self.header if row is None else self.header + 1 + row}: {message}")


def read_sheet(path: str | os.PathLike[str]) -> Sheet:
    """Notes, header and rows of a log file of either layout.

    Args:
        path: The file.

    Returns:
        The file as text.

    Raises:
        LogError: Where the file cannot be read, has no header, or a note or the header is malformed.
    """
    lines = read_text(path, LogError).rstrip().split("\n")
    notes: dict[str, list[str]] = {}
    for number, line in enumerate(lines, start=1):
        if line.startswith("#"):
            _note(f"{path}:{number}", line, notes)
        elif line.strip():
            whole = {key: "; ".join(values) for key, values in notes.items()}
            return _header(path, number, line, whole, lines[number:])
    raise LogError(f"{path}: holds no header and no samples; the first row has to be `time_s,voltage_V,…`")


def _note(where: str, line: str, notes: dict[str, list[str]]) -> None:
    """Puts the note of a line into `notes`; a key given twice keeps both values."""
    key, colon, value = (part.strip() for part in line[1:].partition(":"))
    if not colon and key.lower().startswith("role"):
        raise LogError(f"{where}: `{line}` is no note; write `# role: validate` or `# role: train`")
    if not colon and key.lower().startswith("add ") and "." in key:
        raise LogError(f"{where}: `{line}` is no note; write it with a colon, `# add axis.inertia: 0.012`")
    if value.lower() in ROLES and key.lower() not in ("role", *FREE_TEXT):
        raise LogError(f"{where}: `{line}`: did you mean `# role: {value.lower()}`?")
    if colon:
        notes.setdefault(key.lower(), []).append(value)


def _header(path: str | os.PathLike[str], number: int, line: str, notes: dict[str, str], rows: list[str]) -> Sheet:
    """The sheet whose header is `line`, of whichever layout it is."""
    thesis = [cell.strip() for cell in line.split(";")]
    if thesis == list(THESIS_COLUMNS):
        return Sheet(path, notes, number, thesis, ";", rows)
    sheet = Sheet(path, notes, number, [cell.strip() for cell in line.split(",")], ",", rows)
    if other := next((name for sign, name in ((";", "semicolons"), ("\t", "tabs")) if sign in line), None):
        raise sheet.error(
            None,
            f"the columns are separated by {other}; separate them by commas, and decimals by a point (0.01, not 0,01)",
        )
    if len(sheet.names) > MOST_COLUMNS:
        raise sheet.error(None, f"{len(sheet.names)} columns; a log has {MOST_COLUMNS} at most, `time_s,voltage_V,…`")
    if all(is_number(cell) for cell in sheet.names):
        raise sheet.error(None, "no header; the first row has to name the columns, `time_s,voltage_V,…`")
    return sheet


def numbers(sheet: Sheet, names: list[str]) -> list[np.ndarray]:
    """Columns as numbers.

    Args:
        sheet: The log file as text.
        names: Names of the columns.

    Returns:
        One array (n,) for each name [as in the file], NaN where a cell is empty.

    Raises:
        LogError: With the line of the first row that cannot be read, and where the log is too short.
    """
    if len(sheet.rows) < FEWEST:
        raise sheet.error(None, f"{len(sheet.rows)} samples below the header; a log needs at least {FEWEST}")
    use = [sheet.names.index(name) for name in names]
    separators = len(sheet.names) - 1
    if all(row.count(sheet.delimiter) == separators for row in sheet.rows):
        try:
            table = np.loadtxt(sheet.rows, delimiter=sheet.delimiter, comments=None, usecols=use, ndmin=2)
            return list(np.ascontiguousarray(table.T))
        except ValueError:
            pass  # an empty cell or a mistake: reading row by row fills the one and names the other
    table = np.array([_row(sheet, number, use) for number in range(len(sheet.rows))])
    return list(np.ascontiguousarray(table.T))


def _row(sheet: Sheet, number: int, use: list[int]) -> list[float]:
    """The cells of one row in the columns `use`, NaN where one is empty."""
    text = sheet.rows[number]
    cells = text.split(sheet.delimiter)
    if text.startswith("#"):
        raise sheet.error(number, "a note among the samples; notes go before the header")
    if len(cells) != len(sheet.names):
        comma = "; decimals have a point, 0.01, not 0,01" if len(cells) > len(sheet.names) else ""
        raise sheet.error(number, f"{len(cells)} cells; the header names {len(sheet.names)} columns{comma}")
    try:
        return [float(cells[j]) if cells[j] and not cells[j].isspace() else math.nan for j in use]
    except ValueError:
        j = next(j for j in use if not is_number(cells[j]) and cells[j].strip())
        said = f"`{sheet.names[j]}` is {cells[j].strip()!r}; it has to be a number"
        raise sheet.error(number, f"{said}, or empty where a reading is missing") from None


def is_number(text: str) -> bool:
    """Whether a text reads as a number.

    Args:
        text: A cell or the value of a note.

    Returns:
        True also for `nan` and `inf`.
    """
    try:
        float(text)
    except ValueError:
        return False
    return True


def check_size(sheet: Sheet, name: str, values: np.ndarray, unit: str, factor: float = 1.0) -> None:
    """Checks that no value of a column is larger than that quantity is on any rig.

    Args:
        sheet: The log file as text.
        name: Name of the column.
        values: The column (n,) [as in the file]; NaN is passed over.
        unit: SI unit of the quantity, a key of `kinds.RANGES`.
        factor: What the values are multiplied with to be in that unit [1, or the unit of a count].

    Raises:
        LogError: With the first line in which the value is too large.
    """
    most = RANGES[unit].most
    if len(bad := np.flatnonzero(np.abs(values) * factor > most)):
        row = int(bad[0])
        said = f"`{name}` is {values[row]:.6g}" + ("" if factor == 1.0 else f", {values[row] * factor:.4g} {unit}")
        raise sheet.error(row, f"{said}; {RANGES[unit].quantity} lies between {-most:g} and {most:g} {unit}")


def check_finite(sheet: Sheet, name: str, values: np.ndarray) -> None:
    """Checks that a column has a finite number in every row.

    Args:
        sheet: The log file as text.
        name: Name of the column.
        values: The column (n,) [as in the file].

    Raises:
        LogError: With the first line in which the number is missing or infinite.
    """
    if len(bad := np.flatnonzero(~np.isfinite(values))):
        row = int(bad[0])
        said = "missing" if np.isnan(values[row]) else f"{values[row]}"
        raise sheet.error(row, f"`{name}` is {said}; it has to be a finite number in every row")
