"""Log files (CSV) read: from the file to a checked `Log` in SI, outliers left out."""

import math
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rwjax.errors import LogError, printable
from rwjax.kinds import encoder_section, is_angle
from rwjax.logs.layouts import read_columns
from rwjax.logs.log import Log
from rwjax.logs.notes import added, is_validation
from rwjax.logs.outliers import outliers
from rwjax.logs.sheet import FEWEST, Sheet, check_size, read_sheet
from rwjax.rig.columns import COLUMNS, commands_of, unit_of
from rwjax.rig.model import Rig


def read_logs(paths: Iterable[str | os.PathLike[str]], rig: Rig, outputs_required: bool = True) -> tuple[Log, ...]:
    """Several logs of one rig.

    Args:
        paths: The files.
        rig: The rig that was logged.
        outputs_required: Whether a log without any measured output is an error.

    Returns:
        The logs in the order given, each with a name of its own; logs of the same file name are called by their paths.

    Raises:
        LogError: As `read_log`, and where the same file is named twice.
    """
    given = [Path(path) for path in paths]
    for path, times in Counter(path.resolve() for path in given).items():
        if times > 1:
            raise LogError(f"{path}: named {times} times; name each log once")
    logs = [read_log(path, rig, outputs_required) for path in given]
    return tuple(replace(log, name=name) for log, name in zip(logs, _names(given), strict=True))


def _names(paths: Sequence[Path]) -> list[str]:
    """A name for each log, of characters that are printed: its file's, its path's where others are called so, or that with a number."""
    files, whole = ([printable(str(name)) for name in each] for each in ((path.name for path in paths), paths))
    names = [file if files.count(file) == 1 else path for file, path in zip(files, whole, strict=True)]
    # of two paths that are printed alike, the later one is numbered
    return [f"{name} ({names[:k].count(name) + 1})" if name in names[:k] else name for k, name in enumerate(names)]


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
        name=printable(Path(path).name),
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
    encoder = COLUMNS[name].encoder
    if encoder is None:
        check_size(sheet, name, readings, unit_of(COLUMNS[name].output))
        return 0.0
    if encoder not in rig.counts_per_rev:
        section = encoder_section(encoder, rig.kind)
        raise sheet.error(None, f"`{name}` needs [{section}] counts_per_rev = … in the rig file")
    if len(bad := np.flatnonzero(np.isfinite(readings) & (readings != np.rint(readings)))):
        row = int(bad[0])
        raise sheet.error(row, f"`{name}` is {readings[row]}; counts have to be whole numbers")
    size = 2.0 * math.pi / rig.counts_per_rev[encoder]
    check_size(sheet, name, readings, "rad", size)
    return size
