"""From a table to what a `Log` holds: columns checked, counts as angles, outliers left out."""

import math
from typing import Any

import numpy as np

from rwjax.kinds import TWO_AXIS, encoder_section, is_angle
from rwjax.logs.layouts import read_columns
from rwjax.logs.notes import added, is_validation
from rwjax.logs.outliers import outliers
from rwjax.logs.sheet import FEWEST, Sheet
from rwjax.rig.columns import COLUMNS, ENABLED, commands_of, unit_of
from rwjax.rig.model import Rig


def fields_of(table: Sheet, rig: Rig, outputs_required: bool = True) -> dict[str, Any]:
    """What a table says of one run.

    Args:
        table: The table as a file or a program holds it.
        rig: The rig that was logged.
        outputs_required: Whether a log without any measured output is an error.

    Returns:
        The fields of a `Log` but its name, in SI.

    Raises:
        LogError: With the place, what is wrong and what would be right.
    """
    sheet, series = read_columns(table, rig)
    outputs = {name: y for name, y in series.items() if name in COLUMNS}
    if outputs_required and not outputs:
        valid = ", ".join(f"`{name}`" for name, column in COLUMNS.items() if rig.kind in column.kinds)
        raise sheet.error(None, f"no measured output; a `{rig.kind}` rig needs at least one of {valid}")
    size = {name: _count_size(sheet, name, y, rig) for name, y in outputs.items()}
    column_of = {COLUMNS[name].output: name for name in COLUMNS if name in outputs}
    time, commands = series["time_s"], [name for name in commands_of(rig.kind) if name in series]
    command = np.stack([series[name] for name in commands], axis=1) if rig.kind in TWO_AXIS else series[commands[0]]
    readings = {output: outputs[column] * (size[column] or 1.0) for output, column in column_of.items()}
    wrong = {name: outliers(time, y, None if is_angle(name) else command) for name, y in readings.items()}
    return {
        "time": time,
        "command": command,
        "outputs": {name: np.where(wrong[name], np.nan, y) for name, y in readings.items()},
        "left_out": {name: time[where] for name, where in wrong.items() if where.any()},
        "resolution": {output: size[column] for output, column in column_of.items()},
        "notes": dict(table.notes),
        "validate": is_validation(table),
        "added": added(table, rig),
        "supply": series.get("supply_V"),
        "origin": float(time[0]),
        "input": "voltage_V" if rig.kind in TWO_AXIS else commands[0],
        "enabled": series[ENABLED] == 1.0 if ENABLED in series else None,
    }


def _count_size(sheet: Sheet, name: str, readings: np.ndarray, rig: Rig) -> float:
    """The size of one count [rad] of a column, or 0.0 where it is in SI; `LogError` for readings that cannot be."""
    called = sheet.called(name)
    if len(bad := np.flatnonzero(np.isinf(readings))):
        raise sheet.error(int(bad[0]), f"{called} is infinite; leave the cell empty where a reading is missing")
    if (held := int(np.isfinite(readings).sum())) < FEWEST:
        raise sheet.error(None, f"{called} holds {held} readings; give at least {FEWEST}, or leave the column out")
    if (source := rig.sources.get(name)) is not None and source.unsigned and (readings < 0.0).any():
        row = int(np.flatnonzero(readings < 0.0)[0])
        raise sheet.error(row, f"{called} is {readings[row]:g}, and [columns] says that it is unsigned; take that out")
    encoder = COLUMNS[name].encoder
    if encoder is None:
        sheet.check_size(name, readings, unit_of(COLUMNS[name].output))
        return 0.0
    if encoder not in rig.counts_per_rev:
        section = encoder_section(encoder, rig.kind)
        raise sheet.error(None, f"{called} needs [{section}] counts_per_rev = … in the rig file")
    if len(bad := np.flatnonzero(np.isfinite(readings) & (readings != np.rint(readings)))):
        row = int(bad[0])
        raise sheet.error(row, f"{called} is {readings[row]}; counts have to be whole numbers")
    size = 2.0 * math.pi / rig.counts_per_rev[encoder]
    sheet.check_size(name, readings, "rad", size)
    return size
