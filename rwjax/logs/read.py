"""Log files (CSV) read: from the file to a checked `Log` in SI, outliers left out."""

import math
import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from rwjax.errors import LogError
from rwjax.kinds import encoder_section, is_angle
from rwjax.logs.columns import COLUMNS, commands_of
from rwjax.logs.layouts import read_columns
from rwjax.logs.log import Log
from rwjax.logs.notes import added, is_validation
from rwjax.logs.outliers import outliers
from rwjax.logs.sheet import FEWEST, Sheet, read_sheet
from rwjax.rig.model import Rig

LARGEST = 1e12
"""Size of a reading, in whatever unit, beyond which it cannot be one."""


def read_logs(paths: Iterable[str | os.PathLike[str]], rig: Rig, outputs_required: bool = True) -> tuple[Log, ...]:
    """Several logs of one rig.

    Args:
        paths: The files.
        rig: The rig that was logged.
        outputs_required: Whether a log without any measured output is an error.

    Returns:
        The logs in the order given; logs of the same file name are called by their paths.

    Raises:
        LogError: As `read_log`, and where the same file is named twice.
    """
    given = [Path(path) for path in paths]
    for path, times in Counter(path.resolve() for path in given).items():
        if times > 1:
            raise LogError(f"{path}: named {times} times; name each log once")
    names = Counter(path.name for path in given)
    logs = [(path, read_log(path, rig, outputs_required)) for path in given]
    return tuple(log if names[path.name] == 1 else replace(log, name=str(path)) for path, log in logs)


def read_log(path: str | os.PathLike[str], rig: Rig, outputs_required: bool = True) -> Log:
    """One run, from a log file of rwjax's layout or of the thesis's.

    Args:
        path: The file.
        rig: The rig that was logged.
        outputs_required: Whether a log without any measured output is an error.

    Returns:
        The log in SI.

    Raises:
        LogError: With file, line, what is wrong and what would be right.
    """
    sheet = read_sheet(path)
    series = read_columns(sheet, rig)
    outputs = {name: y for name, y in series.items() if name in COLUMNS}
    if outputs_required and not outputs:
        valid = ", ".join(f"`{name}`" for name, column in COLUMNS.items() if rig.kind in column.kinds)
        raise sheet.error(None, f"no measured output; a `{rig.kind}` rig needs at least one of {valid}")
    size = {name: _count_size(sheet, name, y, rig) for name, y in outputs.items()}
    column_of = {COLUMNS[name].output: name for name in COLUMNS if name in outputs}
    time, commands = series["time_s"], [series[name] for name in commands_of(rig.kind)]
    command = commands[0] if len(commands) == 1 else np.stack(commands, axis=1)
    readings = {output: outputs[column] * (size[column] or 1.0) for output, column in column_of.items()}
    wrong = {name: outliers(time, y, None if is_angle(name) else command) for name, y in readings.items()}
    return Log(
        name=Path(path).name,
        time=time,
        command=command,
        outputs={name: np.where(wrong[name], np.nan, y) for name, y in readings.items()},
        left_out={name: time[where] for name, where in wrong.items() if where.any()},
        resolution={output: size[column] for output, column in column_of.items()},
        notes=sheet.notes,
        validate=is_validation(sheet),
        added=added(sheet, rig),
        supply=series.get("supply_V"),
        origin=float(time[0]),
    )


def _count_size(sheet: Sheet, name: str, readings: np.ndarray, rig: Rig) -> float:
    """The size of one count [rad] of a column, or 0.0 where it is in SI; `LogError` for readings that cannot be."""
    if len(bad := np.flatnonzero(np.isinf(readings))):
        raise sheet.error(int(bad[0]), f"`{name}` is infinite; leave the cell empty where a reading is missing")
    if (held := int(np.isfinite(readings).sum())) < FEWEST:
        raise sheet.error(None, f"`{name}` holds {held} readings; give at least {FEWEST}, or leave the column out")
    if len(bad := np.flatnonzero(np.abs(readings) > LARGEST)):
        raise sheet.error(int(bad[0]), f"`{name}` is {readings[bad[0]]:.4g}; no rig gives more than {LARGEST:.0e}")
    encoder = COLUMNS[name].encoder
    if encoder is None:
        return 0.0
    if encoder not in rig.counts_per_rev:
        section = encoder_section(encoder, rig.kind)
        raise sheet.error(None, f"`{name}` needs [{section}] counts_per_rev = … in the rig file")
    if len(bad := np.flatnonzero(np.isfinite(readings) & (readings != np.rint(readings)))):
        row = int(bad[0])
        raise sheet.error(row, f"`{name}` is {readings[row]}; counts have to be whole numbers")
    return 2.0 * math.pi / rig.counts_per_rev[encoder]
