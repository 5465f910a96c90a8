"""Columns of results as CSV text."""

from collections.abc import Mapping, Sequence

import numpy as np


def csv(columns: Mapping[str, np.ndarray | Sequence]) -> str:
    """A table with one line for each entry of the columns, ten significant digits.

    Args:
        columns: values by the column's name, all of one length; numbers or text. NaN, where there is none, is an empty cell.

    Returns:
        The text of a CSV file, names first.

    Raises:
        ValueError: the columns differ in length.
    """
    rows = zip(*columns.values(), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(_cell, row)) for row in rows), ""])


def _cell(value: object) -> str:
    return value if isinstance(value, str) else "" if value != value else f"{value:.10g}"
