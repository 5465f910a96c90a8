"""A file of any layout as the columns and notes of a log file in rwjax's own."""

import os
from pathlib import Path

import numpy as np

from rwjax.errors import printable
from rwjax.logs.fields import fields_of
from rwjax.logs.layouts import read_columns
from rwjax.logs.read_sheet import read_sheet
from rwjax.rig.model import Rig


def converted(path: str | os.PathLike[str], rig: Rig) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """A file of any layout as what `write_log` takes.

    Args:
        path: The file.
        rig: The rig that was logged; its `[columns]` says what the file's columns are.

    Returns:
        Columns (n,) by rwjax's names, in the units of the names, outliers among them; and the notes.

    Raises:
        LogError: As `read_log`.
    """
    sheet = read_sheet(path)
    fields_of(sheet, rig, outputs_required=False)
    _, series = read_columns(sheet, rig)
    notes = {key: value for key, value in sheet.notes.items() if key != "ignore"}  # what it leaves out is gone
    return series, {**notes, "from": printable(Path(path).name)}
