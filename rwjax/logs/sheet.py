"""A table of measurements before its columns mean anything: names, numbers, and how a wrong one is pointed at."""

import os
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.errors import LogError
from rwjax.kinds import RANGES

FEWEST = 10
"""Samples of a log, and readings of a column, below which nothing can be said."""
ROLES = ("train", "validate")
"""What the note `role` may say: a log is for the fit, or to judge what was fitted."""
FREE_TEXT = ("run", "why", "rig")
"""Keys of notes that name or say something in any words, such as a run that is called `validate`."""
NO_DATES = "dates are read as `time_s` alone, and there without a unit, scale, sign or offset under [columns]"
"""What is said of dates in a column of numbers."""


@dataclass(frozen=True, eq=False)
class Sheet(ABC):
    """A table of measurements, of whatever file or program.

    Attributes:
        path: The file, or the name of what is no file, as messages call it.
        notes: Notes by key in small letters.
        names: Names of the columns.
    """

    path: str | os.PathLike[str]
    notes: Mapping[str, str]
    names: Sequence[str]

    @abstractmethod
    def where(self, row: int | None) -> str:
        """File and place of a row.

        Args:
            row: Index of the row, counted from 0; None for the names of the columns.

        Returns:
            What a message begins with, such as `run.csv:5`.
        """

    def where_noted(self, key: str) -> str:
        """File and place of a note.

        Args:
            key: Its key in small letters.

        Returns:
            What a message begins with: the file alone where notes have no line.
        """
        return f"{self.path}"

    @abstractmethod
    def numbers(self, names: Sequence[str], dates: Collection[str] = ()) -> list[np.ndarray]:
        """Columns as numbers.

        Args:
            names: Names of the columns.
            dates: Those of them that may hold dates, which become seconds from the first one.

        Returns:
            One array (n,) for each name [as in the file], NaN where there is no value.

        Raises:
            LogError: With the place of the first value that is no number, and where there are too few.
        """

    def called(self, name: str) -> str:
        """A column as messages call it.

        Args:
            name: Name of the column.

        Returns:
            The name in quotes.
        """
        return f"`{name}`"

    def to_leave_out(self, name: str) -> str:
        """What a user writes to leave a column out.

        Args:
            name: Name of the column.

        Returns:
            The end of a sentence.
        """
        return "leave it out"

    def error(self, row: int | None, message: str) -> LogError:
        """An error that names the file and the place.

        Args:
            row: Index of the row that is wrong, counted from 0; None for the names of the columns.
            message: What is wrong and what would be right.

        Returns:
            The error, to be raised.
        """
        return LogError(f"{self.where(row)}: {message}")

    def check_size(self, name: str, values: np.ndarray, unit: str, factor: float = 1.0) -> None:
        """Checks that no value of a column is larger than that quantity is on any rig.

        Args:
            name: Name of the column.
            values: The column (n,) [as in the file]; NaN is passed over.
            unit: SI unit of the quantity, a key of `kinds.RANGES`.
            factor: What the values are multiplied with to be in that unit [1, or the unit of a count].

        Raises:
            LogError: With the first row in which the value is too large.
        """
        most = RANGES[unit].most
        if len(bad := np.flatnonzero(np.abs(values) * abs(factor) > most)):
            row = int(bad[0])
            said = f"{self.called(name)} is {values[row]:.6g}"
            said += "" if factor == 1.0 else f", {values[row] * factor:.4g} {unit}"
            raise self.error(row, f"{said}; {RANGES[unit].quantity} lies between {-most:g} and {most:g} {unit}")

    def check_finite(self, name: str, values: np.ndarray) -> None:
        """Checks that a column has a finite number in every row.

        Args:
            name: Name of the column.
            values: The column (n,) [as in the file].

        Raises:
            LogError: With the first row in which the number is missing or infinite.
        """
        if len(bad := np.flatnonzero(~np.isfinite(values))):
            row = int(bad[0])
            said = "missing" if np.isnan(values[row]) else f"{values[row]}"
            raise self.error(row, f"{self.called(name)} is {said}; it has to be a finite number in every row")


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
