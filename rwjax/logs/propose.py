"""A section `[columns]` proposed for a file, by the names of its columns, the units in them, and their values."""

import json
import re
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from rwjax.errors import LogError
from rwjax.kinds import ONE_AXIS, THESIS_COLUMNS, encoder_section
from rwjax.logs.sheet import Sheet
from rwjax.rig.columns import COLUMNS, COMMANDS, columns_of

UNITS = (
    (r"rad\s*/\s*s|rad_s|rads|rad_per_s", "rad/s"),
    (r"deg\s*/\s*s|°\s*/\s*s|deg_s|dps", "deg/s"),
    (r"rpm|rev\s*/\s*min|1\s*/\s*min|min-1", "rpm"),
    (r"[km]?hz", "Hz"),
    (r"n\s*m", "N m"),
    (r"ms|milli\w*", "ms"),
    (r"us|µs|micro\w*", "us"),
    (r"deg|degrees?|°|grad", "deg"),
    (r"rad", "rad"),
    (r"counts?|ticks?|cnt|enc\w*|steps?", "count"),
    (r"mv", "mV"),
    (r"ma", "mA"),
    (r"pct|percent|%", "percent"),
    (r"volts?|v", "V"),
    (r"amps?|a", "A"),
    (r"s|sec\w*", "s"),
)
"""Words of a column's name, and the unit that they mean; the first that is there counts."""
PITCH = ("pitch", "tilt", "roll")
"""Words of axes that are not yaw. A rig with one axis has a single name for it, yaw: such an axis is taken for it where no column is of yaw."""
YAW = "yaw|heading|psi|azimuth"
"""Words of the axis that rwjax calls yaw."""
WORDS = (
    ("time_s", r"t|time\w*|zeit|timestamp|millis|micros|clock|ms|us|sec\w*"),
    ("goal_rad", r"goal\w*|setpoint|set_?point|target\w*|ref\w*|desired|soll\w*"),
    ("supply_V", r"v?bat\w*|supply\w*|vbus|bus"),
    ("enabled", r"enabled?|torque_?on|torque"),
    (
        "voltage_V",
        r"pwm\w*|volt\w*|u|v|cmd\w*|command\w*|input|motor|spannung|dac|duty|throttle\w*|tastgrad|tastverh\w*",
    ),
    ("current_A", r"current\w*|amps?|i|cur|ma|strom|load\w*"),
    ("rate", r"speed\w*|vel\w*|omega|w|rpm|rate|gyro\w*|drehzahl|geschw\w*|dps"),
    (
        "angle",
        rf"angle\w*|pos\w*|theta|yaw|{'|'.join(PITCH)}|psi|phi|present\w*|deg\w*|winkel|counts?|ticks?|cnt|enc\w*|q",
    ),
)
"""Words of a column's name by what they mean; the first that is there counts."""
WHEEL = r"(fly|reaction_?)?wheels?(speed|rate|angle|pos)?|rw"
"""Words of a column's name that say that the motion is a wheel's."""
DUTY = ("duty", "throttle", "tastgrad", "tastverh")
"""How the words of a duty begin."""
PULSE_WIDTH = r"(pwm|throttle)(_?\d+)?[\s_\-.\[(]+(us|µs)\W*$"
"""Names of commands as pulses, whose unit is no time of theirs."""
OF_THROTTLE = r"pct|percent|cmd|command|pwm|duty|norm|raw|in|out|input|output|value|set\w*|des\w*|ref\w*|v|volts?"
"""Words after a throttle that leave it a command."""
NO_THROTTLE = rf"throttle[\W_]*(?!({OF_THROTTLE})(?![a-z]))[a-z]"
"""Names of something else about a throttle, such as its temperature."""
TEMPERATURE = r"\w*temp(eratur\w*)?\d*|\w+temps|thermistor|ntc|celsius|°c|degc"
"""Words of a temperature, which is no quantity of a rig, whatever it is of; `temps` alone is a time in French."""
COUNTS_IN_TIME = r"(^|[\W_])(counts?|ticks?|cnt)(_s|\s*/\s*s(ec)?|[\W_]per[\W_]s(ec)?)\W*$"
"""The end of the name of a rate in counts, of which nothing is known."""
JOINT = r"joint[\W_]*\d*([\W_]*(rad|deg)\W*)?"
"""Names of a joint's angle that say no more than whose it is; without a unit they may be the joint's number as well."""
COMMANDED = r"cmd\w*|command\w*|input"
"""Words of a command, whatever its unit."""
DESIRED = "des"
"""Word of what is asked for: of an angle a goal, and no reading of anything."""
TORQUE = r"nm|torque"
"""Words of a torque."""
ASKED_FOR = r"cmd\w*|command\w*|ref\w*|set\w*|target\w*|des\w*|soll\w*"
"""Words of a torque that is asked for."""
RATES = ("rad/s", "deg/s", "rpm")
"""Units of rates, which no command in volts has."""
QUANTITIES = {
    "voltage_V": ("V", "mV", "percent", "count"),
    "enabled": (),
    "goal_rad": ("rad", "deg", "count"),
    "angle": ("rad", "deg", "count"),
    "rate": (*RATES, "rad", "deg", "count"),
    "current_A": ("A", "mA", "count"),
}
"""Units of a column by what its name means; a name that ends in another unit means something else. A rate's may lack its time."""
SIZE = "abs"
"""Word of a reading without its sign."""
FULL_POWER = (100, 127, 255, 400, 511, 1000, 1023, 4095, 8191, 32767, 65535)
"""Numbers of full power of a PWM."""
SHORTEST_US, NEUTRAL_US, LONGEST_US = 1000.0, 1500.0, 2000.0
"""Pulses of an ESC: full power backwards, none, full power [us]."""
LIKE_VOLTS = 48.0
"""Largest command that is taken for volts [V]."""
THESIS_SECTION = """[columns]
position = "pos1"
pulse = "pwm_1"   # needs [drive] pwm = { neutral_us = …, volts_per_us = … }"""
"""The section for a log of the thesis's layout."""
LIKE_AMPERES = 100.0
"""Largest reading without a unit that is taken for a current [A]; a larger one is a servo's own number."""
SUPPLY_V = 12.0
"""Voltage of a supply of which nothing is known, a guess that is said to be one [V]."""
SUPPLY_GUESSED = f"{SUPPLY_V:g} V is a guess: write the supply's voltage; "
"""What a command's line says then."""
SEVERAL_TURNS = 7.0
"""Angle beyond which one without a unit is taken for degrees where it moves in steps of 0.01 or more [rad]."""


class Proposal(NamedTuple):
    """What a column may be.

    Attributes:
        name: The column of rwjax's.
        line: Its line under `[columns]`.
        column: The column of the file.
    """

    name: str
    line: str
    column: str


def proposal(sheet: Sheet, kind: str, without: Collection[str] = (), supply: float | None = None) -> str:
    """A section `[columns]` for a file.

    Args:
        sheet: The table as the file holds it.
        kind: Kind of the rig.
        without: Columns of rwjax's that the rig does not have.
        supply: Voltage of a PWM at full power [V]; `SUPPLY_V` is a guess where none is given.

    Returns:
        Lines for a rig file, what was not recognised in comments.
    """
    if [*sheet.names] == [*THESIS_COLUMNS]:
        return THESIS_SECTION
    found = {name: one for name, one in proposed(sheet, kind, supply).items() if name not in without}
    other = [column for column in sheet.names if column not in {one.column for one in found.values()}]
    beside = _other_commands(sheet, kind, found, other)
    commanded = [name for name in found if name in COMMANDS]
    missing = [] if "time_s" in found else ['# time_s = { column = "…", unit = "ms" }   # every log needs it']
    missing += [] if commanded else ['# voltage_V = "…"   # every log needs a command']
    missing += [] if any(name in COLUMNS for name in found) else [_no_reading(kind)]
    lines = [found[name].line for name in columns_of(kind) if name in found]
    rest = [column for column in other if column not in beside]
    passed = [f"# passed over: {', '.join(map(partial(_with_text, sheet), rest))}"] if rest else []
    return "\n".join(["[columns]", *lines, *missing, *beside.values(), *passed])


def _with_text(sheet: Sheet, column: str) -> str:
    """A column's name, and the first value that is no number where the name means a quantity."""
    if _meaning(column, [part for part in _parts(column) if part]):
        try:
            sheet.numbers([column])
        except LogError as bad:
            return f"{column} ({bad})"
    return column


def _other_commands(sheet: Sheet, kind: str, found: Mapping[str, Proposal], other: Sequence[str]) -> dict[str, str]:
    """Columns that may be a command as well, each with a line that says why it is passed over and how it is used."""
    if (taken := next((found[name] for name in COMMANDS if name in found), None)) is None:
        return {}
    said = {}
    for column in other:
        values = _values(sheet, column)
        one = _guess(column, values, "joint", None) if values is not None else None
        if one is not None and one.name in COMMANDS and one.name not in columns_of(kind):
            said[column] = (
                f"# passed over: {column}: a `{kind}` rig does not take a {one.name}, and {taken.column} is its command"
            )
            continue
        if one is None or values is None or one.name not in COMMANDS or one.name == taken.name:
            continue
        if one.name != "voltage_V" or values.min() < 0.0 or _of_full_power(column):  # else it may be the supply's
            line = one.line.partition("   #")[0]
            said[column] = (
                f"# passed over: {column}: a log holds one command, and {taken.column} is taken for it; to use {column}, write in the place "
                f"of the line {taken.name}: {line}"
            )
    return said


def _no_reading(kind: str) -> str:
    """The line of a section for a file of which no column is taken for a reading."""
    name = next(name for name in columns_of(kind) if name in COLUMNS and not COLUMNS[name].encoder)
    return f'# {name} = "…"   # no column is taken for a reading, and every log needs one'


def proposed(sheet: Sheet, kind: str, supply: float | None = None) -> dict[str, Proposal]:
    """What the columns of a file may be.

    Args:
        sheet: The table as the file holds it.
        kind: Kind of the rig.
        supply: As in `proposal` [V].

    Returns:
        By rwjax's column the first column of the file that it may be; of rates the first whose name has a unit, where one has. Beside a goal a voltage without a sign is that of the supply, and
        one of both signs takes its place; so does any other command where the rig is no joint; beside any of these a commanded torque is passed over, and beside an angle its counts.
    """
    found: dict[str, Proposal] = {}
    if [*sheet.names] == [*THESIS_COLUMNS]:  # whose columns are not said by rwjax's names
        return found
    names = [column for column in sheet.names if column not in _of_other_axes(sheet, kind)]
    for column in sorted(names, key=_may_be_number):
        values = _values(sheet, column)
        one = _guess(column, values, kind, supply) if values is not None else _dated(sheet, column)
        if one is not None and not (_may_be_number(column) and _is_number(one, values, found)):
            known = found.setdefault(one.name, one)
            of_rate = one.name.endswith("rad_s") and unit_by_name(column) not in ("", "count")
            if of_rate and not unit_by_name(known.column):
                found[one.name] = one  # a gyroscope's raw number may be of another axis
    volts = found.get("voltage_V")
    given = _values(sheet, volts.column) if volts is not None else None
    driven = given is not None and given.min() < 0.0
    torques = (_values(sheet, column) for column in sheet.names if is_commanded_torque(column))
    driven |= any(values is not None and values.any() for values in torques)
    beside = {*found} & {"duty", "command_A", "command_Nm"}
    beside |= {"voltage_V"} if volts is not None and (driven or _of_full_power(volts.column)) else set()
    if driven and "goal_rad" in found and found["goal_rad"].column != "goal_rad":
        del found["goal_rad"]  # a torque, or a voltage of both signs, is what drives, whatever goal it follows
    if kind != "joint" and beside:
        found.pop("goal_rad", None)  # any other rig is driven by what the log says that its drive was given
    if "goal_rad" in found:  # a log holds one command
        found.pop("duty", None)
        volts = found.pop("voltage_V", None)
        if volts is not None and not _of_full_power(volts.column) and "supply_V" in columns_of(kind):
            found.setdefault(
                "supply_V", _line("supply_V", volts.column, "mV" if unit_by_name(volts.column) == "mV" else "")
            )
    if {"voltage_V", "duty", "goal_rad"} & {*found} and "command_Nm" not in sheet.names:
        found.pop("command_Nm", None)
    angles = {COLUMNS[name].output for name in found if name in COLUMNS and not COLUMNS[name].encoder}
    return {
        name: one
        for name, one in found.items()
        if name not in COLUMNS or not COLUMNS[name].encoder or COLUMNS[name].output not in angles
    }


def is_commanded_torque(column: str) -> bool:
    """Whether a column is a torque that is asked for, by its name.

    Args:
        column: The column's name.

    Returns:
        True where a word of it is of a torque, and another one of a command.
    """
    words = re.split(r"[\W_]+", column.lower())
    return all(any(re.fullmatch(pattern, word) for word in words) for pattern in (TORQUE, ASKED_FOR))


def is_asked_for(column: str) -> bool:
    """Whether a column is of what is asked for, by its name, and so no reading.

    Args:
        column: The column's name.

    Returns:
        True where a word of it is one of commands, goals or references.
    """
    return any(re.fullmatch(rf"{ASKED_FOR}|goal\w*", word) for word in re.split(r"[\W_]+", column.lower()))


def is_temperature(column: str) -> bool:
    """Whether a column is a temperature, by its name.

    Args:
        column: The column's name.

    Returns:
        True where a word of it is one of temperatures.
    """
    return any(re.fullmatch(TEMPERATURE, part) for part in _parts(column))


def _may_be_number(column: str) -> bool:
    """Whether a column's name says a joint and no more, whose angle it may be, or whose number."""
    return bool(re.fullmatch(JOINT, column.lower())) and not unit_by_name(column)


def _of_other_axes(sheet: Sheet, kind: str) -> list[str]:
    """Columns of a motion about another axis than the one of the rig: yaw, or that of the first word of `PITCH` where no angle is of yaw."""
    if kind not in ONE_AXIS:
        return []
    means = {column: _meaning(column, [part for part in _parts(column) if part]) for column in sheet.names}
    axis = {c: next((w for w in PITCH if w in _parts(c)), "") for c in sheet.names if means[c] in ("angle", "rate")}
    own = [c for c in axis if not axis[c] and not any(re.fullmatch(WHEEL, part) for part in _parts(c))]
    of_yaw = [c for c in own if means[c] == "angle" or any(re.fullmatch(YAW, part) for part in _parts(c))]
    first = "" if of_yaw else next(filter(None, axis.values()), "")
    return [column for column, word in axis.items() if word and word != first]


def _is_number(one: Proposal, values: np.ndarray | None, found: Collection[str]) -> bool:
    """Whether such a column is the joint's number: it never changes, or another column is the angle."""
    angles = {COLUMNS[name].output for name in found if name in COLUMNS}
    return values is None or float(np.ptp(values)) == 0.0 or COLUMNS[one.name].output in angles


def _dated(sheet: Sheet, column: str) -> Proposal | None:
    """Time by a column of dates whose name means it, None for any other."""
    if _meaning(column, _parts(column)) != "time_s" or _values(sheet, column, dates=[column]) is None:
        return None
    return _line("time_s", column, "")


def _values(sheet: Sheet, column: str, dates: Sequence[str] = ()) -> np.ndarray | None:
    """A column's numbers, None where it has none; as seconds where it is one of those that may hold dates."""
    try:
        values = sheet.numbers([column], dates)[0]
    except LogError:
        return None
    return values[np.isfinite(values)] if np.isfinite(values).any() else None


def _parts(column: str) -> list[str]:
    """The words of a column's name, units with a stroke among them, the last first."""
    small = column.lower()
    rates = re.findall(r"(?:^|[\W_])((?:rad|deg)_s)$", small)
    return [
        *rates,
        *re.findall(r"[\[(]([^\[(\])]*)[\])]", small),
        *reversed(re.split(r"[\s_\-.\[\]()]+", small)),
        small,
    ]


def unit_by_name(column: str) -> str:
    """The unit that a column's name holds.

    Args:
        column: The name.

    Returns:
        A unit of `UNITS`, "" for none.
    """
    parts = [part for part in _parts(column) if part]
    return next((unit for pattern, unit in UNITS if any(re.fullmatch(pattern, part) for part in parts)), "")


def _meaning(column: str, parts: Sequence[str]) -> str:
    """What a column's name means, "" for nothing: the first word that agrees with its unit."""
    if re.search(PULSE_WIDTH, column.lower()):
        return "voltage_V"
    if re.search(NO_THROTTLE, column.lower()) or is_temperature(column) or re.search(COUNTS_IN_TIME, column.lower()):
        return ""
    if re.fullmatch(JOINT, column.lower()):
        return "angle"
    means = [word for word, pattern in WORDS if any(re.fullmatch(pattern, part) for part in parts)]
    in_rates = unit_by_name(column) in RATES
    agreed = [word for word in means if not _ends_otherwise(column, QUANTITIES.get(word))]
    if in_rates and means[:1] in (["voltage_V"], ["angle"]):
        agreed = ["rate"]
    if agreed[:1] != ["time_s"] and ("goal_rad" in means or DESIRED in parts):
        return _asked_for([word for word in agreed if word != "goal_rad"], "goal_rad" in agreed)
    commanded = any(re.fullmatch(COMMANDED, part) for part in parts)
    return agreed[0] if agreed and not (means[0] == "voltage_V" != agreed[0] and commanded) else ""


def _asked_for(of: Sequence[str], goal: bool) -> str:
    """What is asked for means, by what it is of: a voltage drives, and an angle is a servo's goal; a rate or a current is neither."""
    if "voltage_V" in of:
        return "voltage_V"
    return "goal_rad" if "angle" in of or (goal and not of) else ""


def _ends_otherwise(column: str, units: Collection[str] | None) -> bool:
    """Whether a column's name ends in a unit that is none of these; a bare letter may mean anything else, as in `enc_a`."""
    *words, last = re.findall(r"[^\s_\-.\[\]()]+", column) or [""]
    bare = len(last) == 1 and not column.rstrip().endswith(("]", ")"))
    unit = "" if bare or not words else unit_by_name(last)
    return units is not None and unit not in ("", *units)


def _guess(column: str, values: np.ndarray, kind: str, supply: float | None) -> Proposal | None:
    """What a column may be by its name, its unit and its values."""
    valid, parts = columns_of(kind), [part for part in _parts(column) if part]
    if column in valid:
        return Proposal(column, f"{column} = {json.dumps(column)}", column)
    if "command_Nm" in valid and is_commanded_torque(column):
        return _line("command_Nm", column, "", "N m at the joint: right?")
    means, unit = _meaning(column, parts), unit_by_name(column)
    size = SIZE in parts and values.min() >= 0.0
    if means == "time_s":
        return _line("time_s", column, unit if unit in ("ms", "us", "s") else _time_unit(values))
    if means == "voltage_V":
        return command_line(column, values, unit, supply)
    of_wheel = any(re.fullmatch(WHEEL, part) for part in parts)
    if of_wheel and means in ("angle", "rate") and "wheel_rad" not in valid:
        return None
    axis = "wheel" if kind == "wheel" or of_wheel else "yaw"
    if means == "angle":
        if unit == "count" or (not unit and np.array_equal(values, np.rint(values)) and np.ptp(values) > 2.0 * np.pi):
            on = "wheel" if axis == "wheel" else "axis"
            return _line(f"{axis}_counts", column, "", f"needs [{encoder_section(on, kind)}] counts_per_rev")
        degrees = axis == "yaw" and not unit and float(np.ptp(values)) > SEVERAL_TURNS  # a wheel turns many times
        return _line(
            f"{axis}_rad",
            column,
            "deg" if degrees or unit == "deg" else "",
            "degrees by its size: right?" if degrees else "",
        )
    if means == "rate":
        guessed = "" if unit else "rad/s? Else a unit"
        return _line(f"{axis}_rad_s", column, unit if unit in ("deg/s", "rpm") else "", guessed, size)
    if means == "goal_rad" and means in valid:
        return _line(
            "goal_rad",
            column,
            "deg" if unit == "deg" or (not unit and float(np.ptp(values)) > SEVERAL_TURNS) else "",
            "needs [drive.servo]",
        )
    raw = means == "current_A" and not unit and np.max(np.abs(values)) > LIKE_AMPERES
    if means == "current_A" and (raw or np.ptp(values) == 0.0):  # one that never changes is none that was read
        return None
    if means in ("current_A", "supply_V", "enabled") and means in valid:
        guessed = "A? Else a unit" if means == "current_A" and not unit else ""
        return _line(means, column, unit if unit in ("mA", "mV") else "", guessed, size and means == "current_A")
    return None


def command_line(column: str, values: np.ndarray, unit: str, supply: float | None) -> Proposal:
    """A command in volts, in steps of a PWM, or as pulses of an ESC.

    Args:
        column: Name of its column.
        values: Its values (n,) [its unit], at least one.
        unit: The unit that its name holds, "" for none.
        supply: Volts of full power [V], `SUPPLY_V` where none are given.

    Returns:
        The line under `[columns]`, with what a user has to look at.
    """
    size = float(np.max(np.abs(values)))
    if unit == "percent":
        return _line("duty", column, "percent", "needs [drive] supply")
    if size <= 1.0 and any(part.startswith(DUTY) for part in _parts(column)):
        return _line("duty", column, "", "of 1, needs [drive] supply: right?")
    if unit in ("V", "mV") or (size <= LIKE_VOLTS and not _of_full_power(column)):
        whole = "" if unit or size > 1.0 else "V? Of full power it is a duty"
        return _line("voltage_V", column, "mV" if unit == "mV" else "", whole)
    pulses = unit == "us" or (SHORTEST_US <= values.min() and size <= LONGEST_US)
    full = (
        int(LONGEST_US - NEUTRAL_US) if pulses else next((most for most in FULL_POWER if size <= most), FULL_POWER[-1])
    )
    volts = f"{SUPPLY_V:g}" if supply is None else repr(supply).removesuffix(".0")
    scale = f"{volts} V / {full}"
    guess = SUPPLY_GUESSED if supply is None else ""
    why = f"{guess}{full} is full power"
    keys = f"column = {json.dumps(column, ensure_ascii=False)}, scale = {json.dumps(scale)}"
    if pulses:
        keys += f", offset = {NEUTRAL_US:g}"
        why = f"{guess}pulses in us, {volts} V at {LONGEST_US:g} and none at {NEUTRAL_US:g}"
    line = f"voltage_V = {{ {keys} }}"
    return Proposal("voltage_V", f"{line}   # {why}: right?", column)


def _of_full_power(column: str) -> bool:
    """Whether a command is a share of full power by its name, and so no volts."""
    return "pwm" in column.lower() or any(part.startswith(DUTY) for part in _parts(column))


def _time_unit(values: np.ndarray) -> str:
    """The unit of times whose samples lie 0.1 ms to 0.9 s apart."""
    step = float(np.median(np.diff(values))) if len(values) > 1 else 0.0
    return "s" if step < 0.9 else "ms" if step < 900.0 else "us"


def _line(name: str, column: str, unit: str, why: str = "", size: bool = False) -> Proposal:
    """A line under `[columns]`, with what a user has to look at."""
    quoted = json.dumps(column, ensure_ascii=False)
    keys = f", unit = {json.dumps(unit)}" if unit and unit != "s" else ""
    keys += ", unsigned = true" if size else ""
    why = "; ".join(part for part in (why, "never negative, so a size without sign: right?" if size else "") if part)
    source = f"{{ column = {quoted}{keys} }}" if keys else quoted
    return Proposal(name, f"{name} = {source}" + (f"   # {why}" if why else ""), column)


def description(sheet: Sheet) -> Sequence[str]:
    """What columns a file holds.

    Args:
        sheet: The table as the file holds it.

    Returns:
        A line for each column with its range.
    """
    lines = []
    for column in sheet.names:
        values = _values(sheet, column, dates=[column])
        said = "no numbers" if values is None else f"{values.min():.6g} to {values.max():.6g}"
        lines.append(f"  {column}: {said}")
    return lines
