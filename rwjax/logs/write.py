"""Log files (CSV) written: columns and notes, so that every number reads back equal."""

import os
from collections.abc import Mapping

import numpy as np

from rwjax.errors import LogError
from rwjax.text_files import write_text


def write_log(
    path: str | os.PathLike[str], columns: Mapping[str, np.ndarray], notes: Mapping[str, str] | None = None
) -> None:
    """Writes a log file, whole or not at all.

    Args:
        path: The file; one that is there is replaced.
        columns: Columns (n,) by name, in the units of their names; NaN becomes an empty cell.
        notes: Notes above the header by key.

    Raises:
        LogError: Where the file cannot be written.
        ValueError: Where the columns differ in length.
    """
    head = [f"# {key}: {value}" for key, value in (notes or {}).items()]
    cells = [["" if x != x else repr(x) for x in np.asarray(column).tolist()] for column in columns.values()]
    rows = [",".join(row) for row in zip(*cells, strict=True)]
    write_text(path, "\n".join([*head, ",".join(columns), *rows, ""]), LogError)
