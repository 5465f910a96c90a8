"""Reading of log files: `read_log`, `read_logs`."""

import math
import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from rwjax.errors import LogError, alike, nearest
from rwjax.kinds import (
    NUMBERS,
    SIGNS,
    THESIS_COLUMNS,
    TWO_AXIS,
    encoder_section,
    is_angle,
)
from rwjax.logs.columns import COLUMNS, INPUTS, commands_of
from rwjax.logs.log import Log
from rwjax.logs.outliers import outliers
from rwjax.logs.sheet import FEWEST, Sheet, check_finite, is_number, numbers, read_sheet
from rwjax.rig.model import Rig

LARGEST = 1e12  # of a reading, in whatever unit
SLOWEST = 2.0  # s between samples: a motor and an axis do not wait that long
TICK = 0.01  # s, one row of the thesis layout (listing A.2 logs at 100 Hz)


def read_logs(paths: Iterable[str | os.PathLike[str]], rig: Rig, outputs_required: bool = True) -> tuple[Log, ...]:
    """The logs of one call, in the order given; logs of the same file name are called by their paths.

    Raises `LogError` as `read_log` does, and where the same file is named twice.
    """
    given = [Path(path) for path in paths]
    for path, times in Counter(path.resolve() for path in given).items():
        if times > 1:
            raise LogError(f"{path}: named {times} times; name each log once")
    names = Counter(path.name for path in given)
    logs = [(path, read_log(path, rig, outputs_required)) for path in given]
    return tuple(log if names[path.name] == 1 else replace(log, name=str(path)) for path, log in logs)


def read_log(path: str | os.PathLike[str], rig: Rig, outputs_required: bool = True) -> Log:
    """One run, from a log of the interface or of the thesis's layout.

    Raises `LogError` with file, line, what is wrong and what would be right; a log without any measured
    output is such an error unless `outputs_required` is false.
    """
    sheet = read_sheet(path)
    series = _thesis(sheet, rig) if sheet.names == list(THESIS_COLUMNS) else _interface(sheet, rig)
    outputs = {name: y for name, y in series.items() if name in COLUMNS}
    if outputs_required and not outputs:
        valid = ", ".join(f"`{name}`" for name, column in COLUMNS.items() if rig.kind in column.kinds)
        raise sheet.error(None, f"no measured output; a `{rig.kind}` rig needs at least one of {valid}")
    step = {name: _step(sheet, name, y, rig) for name, y in outputs.items()}
    canonical = {name: COLUMNS[name].output for name in COLUMNS if name in outputs}
    time, commands = series["time_s"], [series[name] for name in commands_of(rig.kind)]
    command = commands[0] if len(commands) == 1 else np.stack(commands, axis=1)
    readings = {new: outputs[old] * (step[old] or 1.0) for old, new in canonical.items()}
    wrong = {name: outliers(time, y, None if is_angle(name) else command) for name, y in readings.items()}
    return Log(
        name=Path(path).name,
        time=time,
        command=command,
        outputs={name: np.where(wrong[name], np.nan, y) for name, y in readings.items()},
        left_out={name: time[where] for name, where in wrong.items() if where.any()},
        resolution={new: step[old] for old, new in canonical.items()},
        notes=sheet.notes,
        validate=_validate(sheet),
        added=_added(sheet, rig),
        supply=series.get("supply_V"),
        origin=float(time[0]),
    )


def _validate(sheet: Sheet) -> bool:
    role = sheet.notes.get("role", "train")
    if role not in ("train", "validate"):
        raise LogError(f"{sheet.path}: `# role: {role}` is unknown; it is `train` or `validate`")
    return role == "validate"


def _added(sheet: Sheet, rig: Rig) -> dict[str, float]:
    """Known differences of the rig's numbers in this run, from notes `# add axis.inertia: 0.012`."""
    found = {}
    held = {name.lower(): name for name in rig.values}  # keys of notes are read in small letters
    last = {name.rpartition(".")[2] for name in held}
    for key, value in sheet.notes.items():
        word, _, name = (part.strip() for part in key.partition(" "))
        if word != "add" or " " in name or not ("." in name or name in last):  # any other note
            continue
        if name not in held:
            near = nearest(name, rig.values)
            raise LogError(f"{sheet.path}: `# {key}: {value}`: the rig file has no `{name}`; the nearest is `{near}`")
        if not is_number(value) or not math.isfinite(float(value)):
            raise LogError(f"{sheet.path}: `# {key}: {value}` has to be one number, such as `# {key}: 0.012`")
        name = held[name]
        total = rig.values[name] + float(value)
        sign = NUMBERS[name].sign if name in NUMBERS else "any"
        if not SIGNS[sign](total) or (name.endswith(".inductance") and rig.values[name] == 0.0):
            raise LogError(f"{sheet.path}: `# {key}: {value}` makes `{name}` {total:.6g} from {rig.values[name]:.6g}")
        found[name] = float(value)
    return found


def _interface(sheet: Sheet, rig: Rig) -> dict[str, np.ndarray]:
    """The columns of a log of the interface, as they stand there, but those that a note says to ignore."""
    ignored = [name.strip() for name in sheet.notes.get("ignore", "").replace(";", ",").split(",") if name.strip()]
    if absent := next((name for name in ignored if name not in sheet.names), None):
        near = nearest(absent, sheet.names)
        raise LogError(f"{sheet.path}: `# ignore: {absent}`: no such column; the nearest is `{near}`")
    used = [name for name in sheet.names if name not in ignored]
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
    """A log of the thesis's layout as columns of the interface."""
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
        "time_s": TICK * np.arange(len(pulse)),
        "voltage_V": (pulse - rig.pwm.neutral_us) * rig.pwm.volts_per_us,
        ("wheel_counts" if rig.kind == "wheel" else "yaw_counts"): position,
    }


def _check_header(sheet: Sheet, used: list[str], rig: Rig) -> None:
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


def _step(sheet: Sheet, name: str, readings: np.ndarray, rig: Rig) -> float:
    """The size of one count in SI, or 0.0; raises `LogError` for readings that cannot be."""
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
