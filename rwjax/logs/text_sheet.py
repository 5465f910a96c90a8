"""Text files of measurements: notes, header, and rows of cells, whatever separates them and whatever decimals have."""

import csv
import io
import os
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from rwjax.errors import LogError, counted, printable
from rwjax.kinds import THESIS_COLUMNS
from rwjax.logs.sheet import FEWEST, FREE_TEXT, NO_DATES, ROLES, Sheet, is_number

if TYPE_CHECKING:
    import polars as pl

NO_HEADER = "holds no header and no samples"
"""What is wrong with a file that is empty, but for notes."""
MOST_COLUMNS = 1000
"""Columns of a log: a header of more is no header."""
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", "|": "bars"}
"""What may separate the cells of a row; of several in a header the first here, since decimals may have commas."""
BEGUN = r"[-+]|[-+]?(\d+([.,]\d*)?|[.,]\d+)[eE][-+]?|[-+]?[.,]"
"""What a number leaves that is cut off before its end: a sign, a point, or all but the digits of its exponent."""
DATE = r"^(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d)(:\d\d(?:[.,]\d+)?)? ?(Z|[+-]\d\d(?::?\d\d)?)?$"
"""A date and time by ISO 8601: day, minute, second and time zone."""


class NoHeader(LogError):
    """A file that is empty, but for notes."""


@dataclass(frozen=True, eq=False)
class TextSheet(Sheet):
    """A log file as text.

    Attributes:
        path: The file.
        notes: Lines `# key: value` above the header, by key in small letters.
        names: Names of the columns.
        header: Line number of the header, counted from 1.
        delimiter: What separates the cells of a row.
        rows: The lines below the header.
        noted: Line number of each note by its key, of one given twice that of the last.
    """

    header: int
    delimiter: str
    rows: list[str]
    noted: Mapping[str, int] = field(default_factory=dict)

    def where(self, row: int | None) -> str:
        """File and line of a row."""
        return f"{self.path}:{self.header if row is None else self.header + 1 + row}"

    def where_noted(self, key: str) -> str:
        """File and line of a note."""
        return f"{self.path}:{self.noted[key]}" if key in self.noted else f"{self.path}"

    def to_leave_out(self, name: str) -> str:
        """The note that leaves a column out."""
        return f"write `# ignore: {name}` above the header to leave it out"

    def numbers(self, names: Sequence[str], dates: Collection[str] = ()) -> list[np.ndarray]:
        """Columns as numbers, NaN where a cell is empty."""
        if len(self.rows) < FEWEST:
            raise self.error(None, f"{len(self.rows)} samples below the header; a log needs at least {FEWEST}")
        use = [self.names.index(name) for name in names]
        quoted = any('"' in row for row in self.rows)
        self._check_cells(quoted)
        if not quoted and self.delimiter == ",":
            try:
                table = np.loadtxt(self.rows, delimiter=",", comments=None, usecols=use, ndmin=2)
                return list(np.ascontiguousarray(table.T))
            except ValueError:
                pass  # an empty cell or a mistake: the reader of every other layout fills the one and names the other
        return self._read(use, quoted, dates)

    def _check_cells(self, quoted: bool) -> None:
        """`LogError` for the first row that has more or fewer cells than the header."""
        wanted = len(self.names)
        if quoted:
            counts = (len(cells) for cells in csv.reader(self.rows, delimiter=self.delimiter, strict=False))
        else:
            counts = (row.count(self.delimiter) + 1 for row in self.rows)
        try:
            for number, count in enumerate(counts):
                if count != wanted:
                    raise self._miscounted(number, count)
        except csv.Error as error:
            raise self.error(
                None, f"the rows cannot be told apart ({error}); close every quote on its own line"
            ) from None
        if quoted and number + 1 != len(self.rows):
            bad = next((k for k, row in enumerate(self.rows) if row.count('"') % 2), 0)
            raise self.error(bad, "a quote that does not end on its line; close it there")

    def _miscounted(self, row: int, count: int) -> LogError:
        """What is wrong with a row of so many cells."""
        if (again := self._second_header(row)) is not None:
            return self._begun_anew(again)
        if self.rows[row].startswith("#"):
            return self.error(row, "a note among the samples; notes go before the header")
        comma = count > len(self.names) and self.delimiter == "," and self._has_decimal_commas()
        hint = "; decimals have a point, 0.01, not 0,01, or semicolons between the columns" if comma else ""
        cut = count < len(self.names) and row == len(self.rows) - 1
        hint = "; the last line is cut short: delete it" if cut else hint
        by = "" if self.delimiter == "," else f", separated by {SEPARATORS[self.delimiter]}"
        return self.error(row, f"{counted(count, 'cell')}; the header names {len(self.names)} columns{by}{hint}")

    def _second_header(self, row: int) -> int | None:
        """The row that repeats the header, where nothing but notes and empty lines stand between it and another row.

        Of files that were put one behind the other each may begin with a byte-order mark.
        """
        lines = ((k, self.rows[k].lstrip("\ufeff")) for k in range(row, len(self.rows)))
        beyond = ((k, line) for k, line in lines if line.strip() and not line.startswith("#"))
        first, line = next(beyond, (None, ""))
        return first if [cell.strip(' "') for cell in line.split(self.delimiter)] == self.names else None

    def _begun_anew(self, row: int) -> LogError:
        """What is wrong with a header among the samples."""
        return self.error(
            row, "the header again, as of a logger that was started anew: give each run a file of its own"
        )

    def _has_decimal_commas(self) -> bool:
        """Whether decimals seem to have commas: most rows have more cells than the header names, and hardly one a point."""
        more = sum(row.count(",") >= len(self.names) for row in self.rows)
        pointed = sum("." in row for row in self.rows)
        return more > 0.5 * len(self.rows) > 10.0 * pointed

    def _read(self, use: Sequence[int], quoted: bool, dates: Collection[str]) -> list[np.ndarray]:
        """Columns by their indices, read by polars; those of the names `dates` may hold dates."""
        import polars as pl  # a tenth of a second, which a log of rwjax's own layout does not need

        names = [f"{k}" for k in range(len(self.names))]
        if quoted:  # what a quote means where it stands amid a cell is as `_check_cells` has it
            table = pl.DataFrame([*csv.reader(self.rows, delimiter=self.delimiter)], schema=names, orient="row")
        else:
            text = io.BytesIO("\n".join(self.rows).encode("utf-8", "replace"))
            table = pl.read_csv(
                text,
                has_header=False,
                separator=self.delimiter,
                quote_char=None,
                infer_schema=False,
                schema=dict.fromkeys(names, pl.String),
            )
        columns = [table.to_series(j).cast(pl.String).fill_null("").str.strip_chars() for j in use]
        missing = [(cells == "") | (cells.str.to_lowercase() == "nan") for cells in columns]
        firsts = [
            next(iter(cells.filter(~empty)), "") if self.names[j] in dates else ""
            for j, cells, empty in zip(use, columns, missing, strict=True)
        ]
        dated = [re.match(DATE, first) is not None for first in firsts]
        found = [
            _seconds(cells, first)
            if is_date
            else cells.str.replace(",", ".", literal=True).cast(pl.Float64, strict=False)
            for cells, first, is_date in zip(columns, firsts, dated, strict=True)
        ]
        plain = [cells for cells, is_date in zip(columns, dated, strict=True) if not is_date]
        pointed = any(cells.str.contains(".", literal=True).any() for cells in plain)  # then no comma is a decimal one
        wrong = [
            (number.is_null() & ~empty) | (cells.str.contains(",", literal=True) & (pointed and not is_date))
            for cells, number, empty, is_date in zip(columns, found, missing, dated, strict=True)
        ]
        rows = [int(np.flatnonzero(bad.to_numpy())[0]) if bad.any() else len(self.rows) for bad in wrong]
        if (row := min(rows, default=len(self.rows))) < len(self.rows):
            k = rows.index(row)
            raise self._no_number(row, use[k], columns[k][row], firsts[k])
        return [number.fill_null(np.nan).to_numpy() for number in found]

    def _no_number(self, row: int, j: int, cell: str, first: str) -> LogError:
        """What is wrong with a cell; `first` is the first one of a column that may hold dates, "" for any other."""
        if (again := self._second_header(row)) is not None:
            return self._begun_anew(again)
        said = f"`{self.names[j]}` is {cell!r}; it has to be a number"
        if row == len(self.rows) - 1 and j == len(self.names) - 1 and re.fullmatch(BEGUN, cell):
            return self.error(row, f"{said}; where the last line was cut short, delete it")
        is_date, dated = (re.match(DATE, text) for text in (cell, first))
        if is_date and not first:
            return self.error(row, f"{said}: {NO_DATES}")
        if dated and cell != first:
            said = said.removesuffix("number") + f"date like the first, {first!r}"
            return self.error(row, f"{said}, all with a time zone or all without")
        if is_date and cell != first:
            return self.error(row, f"{said} like the first, {first!r}")
        if first and re.search(r"\d:\d\d", cell):
            return self.error(row, f"{said} of seconds, or a date written as 2024-05-01 12:00:00.010")
        if "," in cell and is_number(cell.replace(",", "")):
            return self.error(row, f"{said}, and beside decimal points a comma is none: write all decimals one way")
        return self.error(row, f"{said}, or empty where a reading is missing")


def _seconds(cells: "pl.Series", first: str) -> "pl.Series":
    """Dates as seconds from the first one, null for any other cell and where not both or neither have a time zone."""
    day, minute, second, zone = cells.str.extract_groups(DATE).struct.unnest()
    at = day + " " + minute + second.fill_null(":00").str.replace(",", ".", literal=True) + zone.fill_null("Z")
    found = at.str.to_datetime("%Y-%m-%d %H:%M:%S%.f%#z", time_unit="us", strict=False).to_physical()
    same = cells == first
    since = ((found - found.filter(same)[0]) / 1e6).round(6)  # polars divides by a product, rounded once more
    return since.set(zone.is_null() != zone.filter(same).is_null()[0], None)


def text_sheet(path: str | os.PathLike[str], text: str) -> TextSheet:
    r"""Notes, header and rows of a text file.

    Args:
        path: The file.
        text: Its text, every line ended by `\n`.

    Returns:
        The file as a table.

    Raises:
        LogError: Where the text has no header, or a note or the header is malformed.
    """
    lines = text.rstrip("\n ").split("\n")  # a tab at the end is a missing reading
    while lines and not lines[-1].strip():
        lines.pop()
    notes: dict[str, list[str]] = {}
    noted: dict[str, int] = {}
    given = ""
    for number, line in enumerate(lines, start=1):
        if line.startswith("#"):
            if key := _note(f"{path}:{number}", line, notes):
                noted[key] = number
        elif number == 1 and line.lower().startswith("sep=") and line[4:5] in SEPARATORS:
            given = line[4]  # as Excel writes it
        elif line.strip():
            whole = {key: "; ".join(values) for key, values in notes.items()}
            return replace(_header(path, number, line, whole, lines[number:], given), noted=noted)
    raise NoHeader(f"{path}: {NO_HEADER}; the first row has to be `time_s,voltage_V,…`")


def _note(where: str, line: str, notes: dict[str, list[str]]) -> str:
    """Puts the note of a line into `notes` and says its key, "" for none; a key given twice keeps both values."""
    key, colon, value = (part.strip() for part in line.lstrip("# ").partition(":"))
    key = printable(key)
    if not colon and key.lower().startswith("role"):
        raise LogError(f"{where}: `{line}` is no note; write `# role: validate` or `# role: train`")
    if not colon and key.lower().startswith("add ") and "." in key:
        raise LogError(f"{where}: `{line}` is no note; write it with a colon, `# add axis.inertia: 0.012`")
    if value.lower() in ROLES and key.lower() not in ("role", *FREE_TEXT):
        raise LogError(f"{where}: `{line}`: did you mean `# role: {value.lower()}`?")
    if not (key and colon):
        return ""
    notes.setdefault(key.lower(), []).append(value)
    return key.lower()


def _header(
    path: str | os.PathLike[str], number: int, line: str, notes: Mapping[str, str], rows: list[str], given: str
) -> TextSheet:
    """The sheet whose header is `line`, whatever separates its names."""
    delimiter = given or next((sign for sign in SEPARATORS if sign in _outside_quotes(line)), ",")
    try:
        names = [re.sub(r"\s", " ", cell).strip() for cell in next(csv.reader([line], delimiter=delimiter))]
    except csv.Error:
        names = [line]
    sheet = TextSheet(path, notes, names, number, delimiter, rows)
    if len(names) > MOST_COLUMNS:
        raise sheet.error(None, f"{len(names)} columns; a log has {MOST_COLUMNS} at most, `time_s,voltage_V,…`")
    if names != list(THESIS_COLUMNS) and all(is_number(cell.replace(",", ".")) for cell in names):
        raise sheet.error(None, "no header; the first row has to name the columns, `time_s,voltage_V,…`")
    return sheet


def _outside_quotes(line: str) -> str:
    """A line without what stands in quotes."""
    return "".join(line.split('"')[::2])
