"""The text of a log file: notes, header, rows, and rows as numbers. What columns mean is in `log.py`."""

import math
import os
from typing import NamedTuple

import numpy as np

from rwjax.errors import LogError, read_text
from rwjax.kinds import THESIS_COLUMNS

FEWEST = 10  # samples of a log, and readings of a column, below which nothing can be said


class Sheet(NamedTuple):
    """A log file as text: its notes, its header and the rows below."""

    path: str | os.PathLike[str]
    notes: dict[str, str]
    header: int  # line number
    names: list[str]
    delimiter: str
    rows: list[str]

    def error(self, row: int | None, message: str) -> LogError:
        """The message with the line of `row`, or of the header."""
        return LogError(f"{self.path}:{self.header if row is None else self.header + 1 + row}: {message}")


def read_sheet(path: str | os.PathLike[str]) -> Sheet:
    """Notes, header and rows of a CSV file of one of the two layouts. Raises `LogError`."""
    lines = read_text(path, LogError).rstrip().split("\n")
    notes: dict[str, str] = {}
    for number, line in enumerate(lines, start=1):
        if line.startswith("#"):
            _note(f"{path}:{number}", line, notes)
        elif line.strip():
            return _header(path, number, line, notes, lines[number:])
    raise LogError(f"{path}: holds no header and no samples; the first row has to be `time_s,voltage_V,…`")


def _note(where: str, line: str, notes: dict[str, str]) -> None:
    key, colon, value = (part.strip() for part in line[1:].partition(":"))
    if not colon and key.lower().startswith("role"):
        raise LogError(f"{where}: `{line}` is no note; write `# role: validate` or `# role: train`")
    if not colon and key.lower().startswith("add ") and "." in key:
        raise LogError(f"{where}: `{line}` is no note; write it with a colon, `# add axis.inertia: 0.012`")
    if value.lower() in ("validate", "train") and key.lower() != "role":
        raise LogError(f"{where}: `{line}`: did you mean `# role: {value.lower()}`?")
    if colon:  # a key given twice keeps both values
        notes[key.lower()] = f"{notes[key.lower()]}; {value}" if key.lower() in notes else value


def _header(path: str | os.PathLike[str], number: int, line: str, notes: dict[str, str], rows: list[str]) -> Sheet:
    thesis = [cell.strip() for cell in line.split(";")]
    if thesis == list(THESIS_COLUMNS):
        return Sheet(path, notes, number, thesis, ";", rows)
    sheet = Sheet(path, notes, number, [cell.strip() for cell in line.split(",")], ",", rows)
    if other := next((name for sign, name in ((";", "semicolons"), ("\t", "tabs")) if sign in line), None):
        raise sheet.error(
            None,
            f"the columns are separated by {other}; separate them by commas, and decimals by a point (0.01, not 0,01)",
        )
    if all(is_number(cell) for cell in sheet.names):
        raise sheet.error(None, "no header; the first row has to name the columns, `time_s,voltage_V,…`")
    return sheet


def numbers(sheet: Sheet, names: list[str]) -> list[np.ndarray]:
    """The columns `names` as numbers, NaN where a cell is empty."""
    if len(sheet.rows) < FEWEST:
        raise sheet.error(None, f"{len(sheet.rows)} samples below the header; a log needs at least {FEWEST}")
    use = [sheet.names.index(name) for name in names]
    separators = len(sheet.names) - 1
    if all(row.count(sheet.delimiter) == separators for row in sheet.rows):
        try:
            table = np.loadtxt(sheet.rows, delimiter=sheet.delimiter, comments=None, usecols=use, ndmin=2)
            return list(np.ascontiguousarray(table.T))
        except ValueError:
            pass  # an empty cell or a mistake: the slow way fills the one and finds the other
    table = np.array([_row(sheet, number, use) for number in range(len(sheet.rows))])
    return list(np.ascontiguousarray(table.T))


def _row(sheet: Sheet, number: int, use: list[int]) -> list[float]:
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
    try:
        float(text)
    except ValueError:
        return False
    return True


def check_finite(sheet: Sheet, name: str, values: np.ndarray) -> None:
    """`LogError` with the first line in which `values` are missing or infinite."""
    if len(bad := np.flatnonzero(~np.isfinite(values))):
        row = int(bad[0])
        said = "missing" if np.isnan(values[row]) else f"{values[row]}"
        raise sheet.error(row, f"`{name}` is {said}; it has to be a finite number in every row")
