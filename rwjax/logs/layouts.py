"""The layouts of a log file, rwjax's own, the thesis's and any that `[columns]` describes, as columns of the first."""

from collections.abc import Sequence

import numpy as np

from rwjax.errors import alike, nearest
from rwjax.kinds import RANGES, THESIS_COLUMNS, TWO_AXIS
from rwjax.logs.mapped_sheet import LAYOUT, mapped
from rwjax.logs.notes import ignored
from rwjax.logs.sheet import Sheet
from rwjax.rig.columns import COLUMNS, ENABLED, INPUTS, columns_of, commands_of, unit_of
from rwjax.rig.model import Rig

SLOWEST = 2.0
"""Longest time between samples [s]: a motor and an axis move within less."""
FASTEST, SHORTEST = 1e-6, 1e-7
"""Shortest median time between samples, and shortest time between any two [s]: a clock in s since 1970 resolves 2.4e-7 s."""
LONGEST_GAP, LONGEST_RUN = 600.0, 25_000.0
"""Longest time without a sample, and longest run [s]: seven hours."""
LATEST = 1e10
"""Latest time that a clock shows [s]: in s since 1970, the year 2286."""
OTHER_TIMES = 'say a unit under [columns], such as `time_s = { column = "NAME", unit = "ms" }`'
"""What to do about a time that is not in seconds."""
THESIS_SAMPLE_S = 0.01
"""Time between rows of the thesis's layout [s] (thesis, listing A.2)."""


def read_columns(sheet: Sheet, rig: Rig) -> tuple[Sheet, dict[str, np.ndarray]]:
    """The columns of a table of any layout, by the names of rwjax's own.

    Args:
        sheet: The table as the file holds it.
        rig: The rig that was logged; it says what the columns of another layout mean.

    Returns:
        The table by rwjax's names, and its columns (n,) in the units of their names; NaN where a reading is missing.

    Raises:
        LogError: Where the columns do not fit the rig, or time and command are not usable.
    """
    left_out = ignored(sheet)
    if ENABLED in sheet.names and ENABLED not in (*columns_of(rig.kind), *left_out):
        raise sheet.error(
            None, f"a `{rig.kind}` rig has no `{ENABLED}`; its columns are {', '.join(columns_of(rig.kind))}"
        )
    if rig.sources and sheet.notes.get(LAYOUT[0]) != LAYOUT[1]:
        sheet = mapped(sheet, rig.sources, columns_of(rig.kind), left_out)
    elif [*sheet.names] == [*THESIS_COLUMNS]:
        return sheet, _thesis(sheet, rig)
    return sheet, _own(sheet, rig, left_out)


def _own(sheet: Sheet, rig: Rig, left_out: Sequence[str]) -> dict[str, np.ndarray]:
    """The columns of a table by rwjax's names, but those that are left out."""
    used = [name for name in sheet.names if name not in left_out]
    _check_header(sheet, used, rig)
    series = dict(zip(used, sheet.numbers(used, ["time_s"]), strict=True))
    for name in (name for name in INPUTS if name in series):
        sheet.check_finite(name, series[name])
    _check_time(sheet, series["time_s"])
    _check_given(sheet, series)
    return series


def _check_time(sheet: Sheet, time: np.ndarray) -> None:
    """`LogError` where the time of the samples is none in seconds, or does not increase as a run's time does."""
    if len(far := np.flatnonzero(np.abs(time) > LATEST)):
        row = int(far[0])
        raise sheet.error(
            row,
            f"{sheet.called('time_s')} is {time[row]:.10g}; a clock shows {LATEST:g} s at most (1.8e+09 since 1970): in seconds? {OTHER_TIMES}",
        )
    step = np.diff(time)
    if len(late := np.flatnonzero(step <= 0.0)):
        row = int(late[0]) + 1
        remedy = (
            "log microseconds, or keep one row of each time stamp"
            if step[row - 1] == 0.0
            else "split the log there where a new run begins, else sort its rows"
        )
        said = f"{sheet.called('time_s')} is {time[row]} after {time[row - 1]}"
        raise sheet.error(row, f"{said}; time has to increase from row to row: {remedy}")
    if len(early := np.flatnonzero(step < SHORTEST)):
        row = int(early[0]) + 1
        raise sheet.error(
            row,
            f"{sheet.called('time_s')} is {step[row - 1]:.4g} s after the row before; samples lie {SHORTEST:g} s apart at least",
        )
    if not FASTEST <= (interval := float(np.median(step))) <= SLOWEST:
        needed = f"every {SLOWEST:g} s at least" if interval > SLOWEST else f"every {FASTEST:g} s at most"
        raise sheet.error(
            None,
            f"{sheet.called('time_s')} has a sample every {interval:.4g} s; a rig needs one {needed}: in seconds? {OTHER_TIMES}",
        )
    widest = int(np.argmax(step))
    if step[widest] > LONGEST_GAP:
        raise sheet.error(
            widest + 1,
            f"{sheet.called('time_s')} is {step[widest]:.4g} s after the row before, and nothing is known of {LONGEST_GAP:g} s without a sample: "
            "split the log there, or check `time_s`",
        )
    if (seconds := float(time[-1] - time[0])) > LONGEST_RUN:
        raise sheet.error(
            len(time) - 1, f"the run takes {seconds:.6g} s; a log has {LONGEST_RUN:g} s at most: split it into several"
        )


def _check_given(sheet: Sheet, series: dict[str, np.ndarray]) -> None:
    """`LogError` where a command is larger than any, the supply gives nothing, or torque is neither on nor off."""
    for name in (name for name in INPUTS if name in series and name != "time_s"):
        sheet.check_size(name, series[name], unit_of(name) or "1")
    supply = series.get("supply_V", np.ones(1))
    if len(off := np.flatnonzero(supply <= 0.0)):
        row = int(off[0])
        said = f"{sheet.called('supply_V')} is {supply[row]:g}"
        raise sheet.error(row, f"{said}; a supply gives more than 0 V: leave the rows or the column out")
    duty = series.get("duty", np.zeros(1))
    if len(beyond := np.flatnonzero(np.abs(duty) > 1.0 + 1e-9)):
        row = int(beyond[0])
        number = 'in percent, unit = "percent"; as of 255, scale = "1/255"'
        remedy = f'divide it, or write duty = {{ column = "…", … }} under [columns] of the rig file ({number})'
        raise sheet.error(row, f"{sheet.called('duty')} is {duty[row]:g}; a duty lies between -1 and 1: {remedy}")
    enabled = series.get(ENABLED, np.zeros(1))
    if len(neither := np.flatnonzero((enabled != 0.0) & (enabled != 1.0))):
        row = int(neither[0])
        raise sheet.error(
            row, f"{sheet.called(ENABLED)} is {enabled[row]:g}; it has to be 1 where torque is on, 0 where it is off"
        )


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
    position, pulse = sheet.numbers([rig.columns["position"], rig.columns["pulse"]])
    sheet.check_finite(rig.columns["pulse"], pulse)
    volts = (pulse - rig.pwm.neutral_us) * rig.pwm.volts_per_us
    if len(bad := np.flatnonzero(np.abs(volts) > RANGES["V"].most)):
        row = int(bad[0])
        raise sheet.error(
            row,
            f"`{rig.columns['pulse']}` is {pulse[row]:.6g}, {volts[row]:.4g} V by `drive.pwm`; no drive gives as much",
        )
    return {
        "time_s": THESIS_SAMPLE_S * np.arange(len(pulse)),
        "voltage_V": volts,
        ("wheel_counts" if rig.kind == "wheel" else "yaw_counts"): position,
    }


def _check_header(sheet: Sheet, used: list[str], rig: Rig) -> None:
    """`LogError` where a column is missing, unknown, of another kind of rig, or there twice."""
    commands = commands_of(rig.kind)
    given = [name for name in used if name in commands]
    _check_held(sheet, used, rig, ["time_s", *(commands if rig.kind in TWO_AXIS else given[:1] or commands[:1])])
    if len(given) > 1 and rig.kind not in TWO_AXIS and given[0] != given[1]:
        raise sheet.error(
            None, f"`{given[0]}` and `{given[1]}` are both commands, and a log holds one; leave the other out"
        )
    valid = columns_of(rig.kind)
    held: dict[str, str] = {}
    for name in used:
        output = COLUMNS[name].output if name in COLUMNS else name
        if (name in COLUMNS or name in INPUTS) and name not in valid:
            raise sheet.error(None, f"a `{rig.kind}` rig has no `{name}`; its columns are {', '.join(valid)}")
        if not name:
            raise sheet.error(None, f"column {[*sheet.names].index(name) + 1} has no name; name it, or take it out")
        if name not in valid:
            raise sheet.error(None, f"unknown column `{name}`; {_to_name(sheet, name, valid)}")
        if output in held:
            raise sheet.error(None, f"`{held[output]}` and `{name}` are the same reading; keep one of them")
        held[output] = name


def _to_name(sheet: Sheet, name: str, valid: Sequence[str]) -> str:
    """What is to be done about a column that goes by none of rwjax's names: a reading is not to be thrown away."""
    meant = f"did you mean `{nearest(name, valid)}`? Else, " if alike(name, valid) else ""
    meant = "rates are in rad/s (1/min times π/30); " if "rpm" in name.lower() else meant
    how = "say which by [columns] of the rig file (`rwjax import FILE` proposes it)"
    if sheet.notes.get(LAYOUT[0]) == LAYOUT[1]:  # for which [columns] does not count
        how = f"give it a name of rwjax's ({', '.join(valid)})"
    return f"{meant}if it is a reading, {how}; else {sheet.to_leave_out(name)}"


def _check_held(sheet: Sheet, used: list[str], rig: Rig, needed: list[str]) -> None:
    """`LogError` where a column is missing that every log needs."""
    for name in needed:
        if name not in used:
            found = ", ".join(f"`{each}`" for each in used) or "none"
            near = f", nearest `{nearest(name, used)}`" if alike(name, used) else ""
            other = " (`rwjax import FILE` proposes [columns] that read the file as it is)" if len(used) > 1 else ""
            others = [each for each in commands_of(rig.kind) if name == "voltage_V" and each != name]
            or_else = f"; in its place {' or '.join(others)} may stand" if others else ""
            raise sheet.error(None, f"no column `{name}`, which every log needs; found {found}{near}{other}{or_else}")
