"""Writing of log files: `write_log`."""

import os
from collections.abc import Mapping

import numpy as np

from rwjax.errors import LogError, write_text


def write_log(
    path: str | os.PathLike[str], columns: Mapping[str, np.ndarray], notes: Mapping[str, str] | None = None
) -> None:
    """Writes columns of equal length as CSV, every number so that it reads back equal, NaN as an empty cell.

    The file appears whole or not at all. Raises `LogError` if it cannot be written.
    """
    head = [f"# {key}: {value}" for key, value in (notes or {}).items()]
    cells = [["" if x != x else repr(x) for x in np.asarray(column).tolist()] for column in columns.values()]
    rows = [",".join(row) for row in zip(*cells, strict=True)]
    write_text(path, "\n".join([*head, ",".join(columns), *rows, ""]), LogError)
