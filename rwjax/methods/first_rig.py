"""A first rig file, from the columns of logs and the numbers of a datasheet. What is guessed is free where logs can tell it, and said."""

import json
import re
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from rwjax.errors import InputError, printable
from rwjax.kinds import MOTORED, NUMBERS, SERVO, TURNING, WHEELED, encoder_section
from rwjax.logs.propose import proposal
from rwjax.logs.read import read_logs
from rwjax.logs.read_sheet import read_sheet
from rwjax.methods.regression import weak_form
from rwjax.rig.columns import COLUMNS
from rwjax.rig.read import parse_rig

GRAVITY = 9.81
"""[m/s²]."""
DIGITS = 3
"""Digits of an estimate, which `fit` will make anew."""


class Datasheet(NamedTuple):
    """What a datasheet or a scale says; None for what is not known.

    Attributes:
        supply: Voltage at which the others hold [V].
        stall_torque: Torque at standstill [N m], behind the gear.
        no_load_speed: Speed without a load [rad/s], behind the gear.
        resistance: Resistance of the winding [ohm].
        mass: Mass of the link, as of a rod [kg].
        length: Its length from the axis [m].
        counts: Counted edges per turn of the encoder [1].
    """

    supply: float | None = None
    stall_torque: float | None = None
    no_load_speed: float | None = None
    resistance: float | None = None
    mass: float | None = None
    length: float | None = None
    counts: float | None = None


class Known(NamedTuple):
    """A number of the first rig file.

    Attributes:
        value: Its value [SI].
        why: Where it comes from, in words.
        free: Whether a fit is to estimate it.
    """

    value: float
    why: str
    free: bool = False


GUESS, REGRESSION = "a guess", "by a regression; `rwjax fit` estimates it anew"


def first_rig(paths: Sequence[str | PathLike[str]], datasheet: Datasheet, kind: str | None = None) -> str:
    """The text of a first rig file for logs.

    Args:
        paths: The logs, of any layout; the first one says the columns.
        datasheet: What is known beforehand.
        kind: Kind of the rig, one of `rwjax.kinds.ONE_AXIS`; by the columns where none is given.

    Returns:
        TOML text. Free numbers are estimated by a regression on the smoothed motion, where the logs allow it; else a comment says why not.

    Raises:
        LogError: A log cannot be read.
    """
    sheet = read_sheet(paths[0])
    kind = kind or _kind_of(_columns(proposal(sheet, "reaction")))
    section = proposal(sheet, kind)
    columns = _columns(section)
    own = columns <= {*sheet.names}  # the file has rwjax's own names
    name = Path(paths[0]).resolve().parent.name or "rig"
    numbers = _numbers(kind, datasheet, columns)

    def text(numbers: dict[str, Known]) -> str:
        return _text(kind, name, numbers, datasheet, columns, "" if own else section)

    try:
        rig = parse_rig(text(numbers))
        found = weak_form(rig, read_logs(paths, rig)).rig.values
    except InputError as why:
        return f"# No number is estimated yet: {printable(str(why))}\n{text(numbers)}"
    told = {n: known._replace(value=_rounded(found[n]), why=REGRESSION) for n, known in numbers.items() if known.free}
    return text(numbers | told)


def _columns(section: str) -> set[str]:
    """The columns of rwjax's that a proposed section has."""
    return {*re.findall(r"^(\w+) =", section, flags=re.MULTILINE)}


def _kind_of(columns: set[str]) -> str:
    """Kind of a rig by the columns of its logs; what has a goal, a duty or a current as its command is a joint."""
    axis = any(name.startswith(("yaw", "position")) for name in columns)
    if any(name.startswith("wheel") for name in columns):
        return "reaction" if axis else "wheel"
    return "joint" if columns & {"goal_rad", "duty", "command_A", "command_Nm", "current_A"} else "platform"


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _numbers(kind: str, d: Datasheet, columns: set[str]) -> dict[str, Known]:
    """Every number of the first rig file, by its name."""
    found = _motor(d, columns) if kind in MOTORED else {}
    if kind == "platform":
        found["drive.gain"] = (
            Known(_rounded(d.stall_torque / d.supply), "stall torque over the voltage")
            if d.stall_torque and d.supply
            else Known(1.0, "unknown: with 1, torques and inertias are in units of the drive's gain")
        )
    if kind in WHEELED:
        found["wheel.inertia"] = Known(1e-4, GUESS, free=True)
        found["motor.friction"] = Known(1e-6, GUESS, free=True)
    if "duty" in columns:
        found["drive.supply"] = Known(d.supply, "given") if d.supply else Known(12.0, GUESS)
    if kind in TURNING:
        rod = d.mass * d.length**2 / 3.0 if d.mass and d.length else None
        found["axis.inertia"] = (
            Known(_rounded(rod), "of a rod, m l²/3", free=True) if rod else Known(0.1, GUESS, free=True)
        )
        found["axis.friction.viscous"] = Known(0.01, GUESS, free=True)
        if kind == "joint" and d.mass and d.length:
            torque = _rounded(0.5 * d.mass * GRAVITY * d.length)
            found["axis.gravity.torque"] = Known(torque, "of a rod that hangs down at angle 0, m g l/2", free=True)
            found["axis.gravity.angle"] = Known(0.0, "0 where the rod hangs down")
    if "goal_rad" in columns:
        found["drive.servo.kp"] = Known(10.0, GUESS, free=True)
        found["drive.servo.kd"] = Known(0.0, GUESS)
    return found


def _motor(d: Datasheet, columns: set[str]) -> dict[str, Known]:
    """Torque constant and resistance, seen behind the gear."""
    if "command_Nm" in columns:
        return {}
    if d.supply and d.no_load_speed:
        K = Known(_rounded(d.supply / d.no_load_speed), "voltage over the speed without a load")
    elif d.supply and d.stall_torque and d.resistance:
        K = Known(_rounded(d.stall_torque * d.resistance / d.supply), "stall torque times resistance over the voltage")
    else:
        told = bool(columns & {"voltage_V", "duty"}) and any(name.startswith(("wheel", "position")) for name in columns)
        K = Known(0.02, GUESS, free=told)
    if d.resistance:
        R = Known(d.resistance, "given")
    elif d.supply and d.stall_torque and d.no_load_speed:
        R = Known(_rounded(K.value * d.supply / d.stall_torque), "torque constant times voltage over the stall torque")
    else:
        R = Known(1.0, f"{GUESS}; motions tell K²/R and J/K² alone, so that torques are as wrong as this is")
    return {"motor.torque_constant": K, "motor.resistance": R}


def _text(
    kind: str, name: str, numbers: dict[str, Known], datasheet: Datasheet, columns: set[str], section: str
) -> str:
    """The rig file."""
    lines = [f'kind = "{kind}"', f"name = {json.dumps(name, ensure_ascii=False)}"]
    for part in dict.fromkeys(key.rpartition(".")[0] for key in NUMBERS if key in numbers):
        lines += ["", f"[{part}]"]
        lines += ['acts_on = "voltage"   # a guess: or "duty", "current", "torque"'] if part == SERVO else []
        for key in (key for key in NUMBERS if key in numbers and key.rpartition(".")[0] == part):
            known, n = numbers[key], NUMBERS[key]
            lines.append(f"{key.rpartition('.')[2]} = {known.value!r}   # {n.symbol}, {n.unit}: {known.why}")
    for column in (name for name in COLUMNS if name in columns):
        if on := COLUMNS[column].encoder:
            counts = f"{datasheet.counts:g}" if datasheet.counts else "2048   # a guess: counted edges per turn"
            lines += ["", f"[{encoder_section(on, kind)}]", f"counts_per_rev = {counts}"]
    lines += ["", *section.splitlines()] if section else []
    free = ", ".join(f'"{key}"' for key, known in numbers.items() if known.free)
    return "\n".join(
        [*lines, "", "[fit]", f"free = [{free}]   # estimated by `rwjax fit`; all else is taken as known", ""]
    )
