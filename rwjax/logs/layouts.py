"""The two layouts of a log file, rwjax's own and the thesis's, as columns of the former."""

import numpy as np

from rwjax.errors import alike, nearest
from rwjax.kinds import THESIS_COLUMNS, TWO_AXIS
from rwjax.logs.columns import COLUMNS, INPUTS, commands_of
from rwjax.logs.notes import ignored
from rwjax.logs.sheet import Sheet, check_finite, numbers
from rwjax.rig.model import Rig

SLOWEST = 2.0
"""Longest time between samples [s]: a motor and an axis move within less."""
THESIS_SAMPLE_S = 0.01
"""Time between rows of the thesis's layout [s] (thesis, listing A.2)."""


def read_columns(sheet: Sheet, rig: Rig) -> dict[str, np.ndarray]:
    """The columns of a log file of either layout, by the names of rwjax's own.

    Args:
        sheet: The log file as text.
        rig: The rig that was logged; it says what the columns of the thesis's layout mean.

    Returns:
        Columns (n,) by name, in the units of their names; NaN where a reading is missing.

    Raises:
        LogError: Where the columns do not fit the rig, or time and command are not usable.
    """
    return (_thesis if sheet.names == list(THESIS_COLUMNS) else _own)(sheet, rig)


def _own(sheet: Sheet, rig: Rig) -> dict[str, np.ndarray]:
    """The columns of a log of rwjax's layout as they stand there, but those that a note says to ignore."""
    left_out = ignored(sheet)
    used = [name for name in sheet.names if name not in left_out]
    _check_header(sheet, used, rig)
    series = dict(zip(used, numbers(sheet, used), strict=True))
    for name in (name for name in INPUTS if name in series):
        check_finite(sheet, name, series[name])
    time = series["time_s"]
    if len(late := np.flatnonzero(np.diff(time) <= 0.0)):
        row = int(late[0]) + 1
        raise sheet.error(row, f"`time_s` is {time[row]} after {time[row - 1]}; time has to increase from row to row")
    if (interval := float(np.median(np.diff(time)))) > SLOWEST:
        raise sheet.error(
            None,
            f"`time_s` has a sample every {interval:.4g} s; a rig needs one every {SLOWEST:g} s at least: seconds?",
        )
    return series


def _thesis(sheet: Sheet, rig: Rig) -> dict[str, np.ndarray]:
    """A log of the thesis's layout as columns of rwjax's own."""
    if rig.kind in TWO_AXIS:
        needed = f"`time_s`, {', '.join(f'`{name}`' for name in commands_of(rig.kind))} and readings"
        raise sheet.error(None, f"a log of the thesis's layout holds one axis; a `{rig.kind}` rig needs {needed}")
    for key, right in (("position", '"pos1" or "pos2"'), ("pulse", '"pwm_1" or "pwm_2"')):
        if key not in rig.columns:
            raise sheet.error(None, f"the thesis layout needs [columns] {key} = {right} in the rig file")
    if rig.pwm is None:
        needed = "[drive] pwm = { neutral_us = …, volts_per_us = … }"
        raise sheet.error(None, f"the thesis layout needs {needed} in the rig file")
    position, pulse = numbers(sheet, [rig.columns["position"], rig.columns["pulse"]])
    check_finite(sheet, rig.columns["pulse"], pulse)
    return {
        "time_s": THESIS_SAMPLE_S * np.arange(len(pulse)),
        "voltage_V": (pulse - rig.pwm.neutral_us) * rig.pwm.volts_per_us,
        ("wheel_counts" if rig.kind == "wheel" else "yaw_counts"): position,
    }


def _check_header(sheet: Sheet, used: list[str], rig: Rig) -> None:
    """`LogError` where a column is missing, unknown, of another kind of rig, or there twice."""
    found = ", ".join(f"`{name}`" for name in used)
    inputs = ("time_s", *commands_of(rig.kind))
    for name in inputs:
        if name not in used:
            near = f", nearest `{nearest(name, used)}`" if alike(name, used) else ""
            raise sheet.error(None, f"no column `{name}`, which every log needs; found {found or 'none'}{near}")
    valid = [*inputs, "supply_V", *(name for name, column in COLUMNS.items() if rig.kind in column.kinds)]
    held: dict[str, str] = {}
    for name in used:
        output = COLUMNS[name].output if name in COLUMNS else name
        if (name in COLUMNS or name in INPUTS) and name not in valid:
            raise sheet.error(None, f"a `{rig.kind}` rig has no `{name}`; its columns are {', '.join(valid)}")
        if not name:
            raise sheet.error(None, f"column {sheet.names.index(name) + 1} has no name; name it, or take it out")
        if name not in valid:
            meant = f"did you mean `{nearest(name, valid)}`? Else " if alike(name, valid) else ""
            meant = "rates are in rad/s (1/min times π/30). Else " if "rpm" in name.lower() else meant
            raise sheet.error(
                None, f"unknown column `{name}`; {meant}write `# ignore: {name}` above the header to leave it out"
            )
        if output in held:
            raise sheet.error(None, f"`{held[output]}` and `{name}` are the same reading; keep one of them")
        held[output] = name
