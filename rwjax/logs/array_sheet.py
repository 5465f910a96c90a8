"""Tables that hold numbers already: Parquet, MAT and NPZ files, data frames and arrays."""

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rwjax.errors import LogError
from rwjax.logs.sheet import FEWEST, NO_DATES, Sheet

MOST_TOGETHER = 100
"""Columns of one array."""
DEEPEST = 4
"""Structures within structures of a MAT file that are looked into."""


@dataclass(frozen=True, eq=False)
class ArraySheet(Sheet):
    """Columns that are arrays.

    Attributes:
        path: The file, or the name of what is no file.
        notes: Notes by key in small letters.
        names: Names of the columns.
        columns: Arrays of any kind by name.
        row: What a row is called in messages.
    """

    columns: Mapping[str, Any]
    row: str = "row"

    def where(self, row: int | None) -> str:
        """File and number of a row, or the name of what is no file and the number of a sample."""
        return f"{self.path}" if row is None else f"{self.path}: {self.row} {row + 1}"

    def numbers(self, names: Sequence[str], dates: Collection[str] = ()) -> list[np.ndarray]:
        """Columns as numbers, NaN where there is no value."""
        found = [self._number(name, name in dates) for name in names]
        for name, values in zip(names, found, strict=True):
            if len(values) != len(found[0]):
                raise self.error(
                    None, f"`{name}` has {len(values)} values, and `{names[0]}` {len(found[0])}; give equally many"
                )
        if found and len(found[0]) < FEWEST:
            raise self.error(None, f"{len(found[0])} samples; a log needs at least {FEWEST}")
        return found

    def _number(self, name: str, dates: bool) -> np.ndarray:
        """One column as numbers, dates as seconds from the first where it may hold them."""
        held = self.columns[name]
        given = (
            np.ma.filled(np.ma.asarray(held, float), np.nan)
            if isinstance(held, np.ma.MaskedArray)
            else np.asarray(held)
        )
        if given.ndim == 2 and 1 in given.shape:
            given = given.ravel()
        if given.ndim != 1:
            raise self.error(None, f"`{name}` has the shape {given.shape}; a column has one value for each sample")
        if given.dtype.kind in "mM":
            if not dates:
                raise self.error(None, f"`{name}` holds dates; {NO_DATES}")
            seconds = (given - given[:1]) / np.timedelta64(1, "ns") / 1e9 if len(given) else np.zeros(0)
            return np.asarray(seconds, float)
        if given.dtype.kind in "biuf":
            return given.astype(float)
        if given.dtype.kind == "c":
            raise self.error(None, f"`{name}` holds complex numbers; give real ones")
        return np.array([self._one(name, k, value) for k, value in enumerate(given.tolist())], float)

    def _one(self, name: str, row: int, value: Any) -> float:
        """One value of a column of anything."""
        if value is None or (isinstance(value, str) and not value.strip()):
            return np.nan
        try:
            return float(value)
        except OverflowError:
            raise self.error(row, f"`{name}` is too large for a number; it has to be a number, or missing") from None
        except (TypeError, ValueError):
            shown = repr(value) if isinstance(value, str | bytes | int | float) else f"a {type(value).__name__}"
            raise self.error(row, f"`{name}` is {shown}; it has to be a number, or missing") from None


def array_sheet(path: str | os.PathLike[str], columns: Mapping[str, Any], row: str = "row") -> ArraySheet:
    """A table of the rows of numbers among some values: arrays, tables of several columns, structures of these.

    Args:
        path: The file, or the name of what is no file.
        columns: Values by name.
        row: What a row is called in messages.

    Returns:
        The table. A column of a structure goes by `structure.name`, and by its own name where that is no other's; of an array
        of several columns each goes by the name and its number from 1, `name_1`.

    Raises:
        LogError: Where there is none.
    """
    flat: dict[str, Any] = {}
    for name, value in columns.items():
        _flatten(f"{name}", value, flat, DEEPEST)
    last = [name.rpartition(".")[2] for name in flat]
    short = {own: flat[name] for name, own in zip(flat, last, strict=True) if own not in flat and last.count(own) == 1}
    if not flat:
        raise LogError(f"{path}: holds no column of numbers; give arrays of one value for each sample")
    whole = flat | short
    return ArraySheet(path, {}, list(whole), whole, row)


def _flatten(name: str, value: Any, into: dict[str, Any], depth: int) -> None:
    """Puts every row of numbers of a value into a table."""
    if isinstance(value, Mapping):
        for key, each in value.items() if depth else ():
            _flatten(f"{name}.{key}", each, into, depth - 1)
        return
    try:
        shape = np.shape(value)
    except ValueError:  # rows of several lengths
        return
    if len(shape) == 2 and 1 < min(shape) < max(shape) and min(shape) <= MOST_TOGETHER:
        table = np.asarray(value) if shape[0] >= shape[1] else np.asarray(value).T
        into |= {f"{name}_{k + 1}": table[:, k] for k in range(table.shape[1])}
    elif (len(shape) == 1 or (len(shape) == 2 and 1 in shape)) and max(shape, default=0) > 1:
        into[name] = value
