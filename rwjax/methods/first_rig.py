"""A first rig file, from the columns of logs and the numbers of a datasheet. What is guessed is free where logs can tell it, and said."""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rwjax.errors import InputError, LogError, no_name, printable, printable_lines
from rwjax.kinds import MOTORED, NUMBERS, ONE_AXIS, SERVO, THESIS_COLUMNS, TURNING, WHEELED, encoder_section
from rwjax.logs.mapped_sheet import LAYOUT
from rwjax.logs.propose import (
    SUPPLY_GUESSED,
    SUPPLY_V,
    command_line,
    is_commanded_torque,
    is_temperature,
    proposal,
    proposed,
    unit_by_name,
)
from rwjax.logs.read import read_logs
from rwjax.logs.read_sheet import read_sheet
from rwjax.logs.sheet import Sheet
from rwjax.methods.first_estimates import WEIGHT, first_estimates, rounded
from rwjax.methods.hanging import hanging
from rwjax.methods.known import Known
from rwjax.methods.mujoco_joint import MujocoJoint
from rwjax.methods.servo_scale import KD, KP, servo_numbers
from rwjax.rig.columns import COLUMNS, columns_of, commands_of
from rwjax.rig.model import GUESS
from rwjax.rig.parse import PERIOD
from rwjax.rig.read import parse_rig

GRAVITY = 9.81
"""[m/s²]."""
OWN_NUMBERS = {
    "torque_constant": "motor.torque_constant",
    "resistance": "motor.resistance",
    "wheel_inertia": "wheel.inertia",
    "axis_inertia": "axis.inertia",
    "gain": "drive.gain",
    "kp": KP,
    "kd": KD,
}
"""Numbers that the datasheet gives as they are, by its attributes."""


class Datasheet(NamedTuple):
    """What a datasheet or a scale says; None for what is not known.

    Attributes:
        supply: Voltage at which the others hold, and that of a PWM at full power [V].
        stall_torque: Torque at standstill [N m], behind the gear.
        no_load_speed: Speed without a load [rad/s], behind the gear.
        resistance: Resistance of the winding [ohm].
        mass: Mass of the link [kg]: of a rod, or of a bob at the end of an arm whose own mass does not count.
        length: Its length from the axis [m].
        counts: Counted edges per turn of the encoder [1].
        torque_constant: Torque constant of the motor [N m/A], behind the gear.
        wheel_inertia: Moment of inertia of wheel and rotor [kg m²].
        axis_inertia: Moment of inertia of what the axis carries [kg m²].
        bob: Whether the mass sits at the end of the length; along all of it where it does not.
        gain: Gain of a platform's drive, its torque per volt [N m/V].
        kp: Gain of the servo's loop [V/rad, or 1, A or N m per rad by what it acts on].
        kd: Its rate gain [V s/rad, or by what it acts on].
    """

    supply: float | None = None
    stall_torque: float | None = None
    no_load_speed: float | None = None
    resistance: float | None = None
    mass: float | None = None
    length: float | None = None
    counts: float | None = None
    torque_constant: float | None = None
    wheel_inertia: float | None = None
    axis_inertia: float | None = None
    bob: bool = False
    gain: float | None = None
    kp: float | None = None
    kd: float | None = None

    @property
    def of_a_motor(self) -> bool:
        """Whether it holds numbers of a motor that no other drive has."""
        return bool(self.torque_constant or self.resistance)


OF_A_VALUE = ("counts", "bob")
"""What of a datasheet is no number that others are worked out from."""
SUPPLY_ALONE = (
    "; it tells a motor together with --no-load-speed or --stall-torque, and PWM counts or a duty their voltage"
)
OF_TWO_AXES = {*columns_of("two_axis")} - {name for kind in ONE_AXIS for name in columns_of(kind)}
"""Columns that rigs with two axes alone have."""
OF_A_WEIGHT = [
    "",
    "# [axis.gravity]   # of a link that hangs, or an axis that leans: take away the three marks",
    '# torque = 0.1   # m g l, N m: mass times 9.81 times the lever of its centre; unknown, "axis.gravity.torque" under [fit]',
    "# angle = 0.0   # angle, rad: 0 where it hangs down at angle 0",
]
"""Lines for gravity, which nothing in a log's columns tells."""
OTHER_UNIT = r"°?[cfk]|celsius|kelvin|[hkm]?pa|m?bar|[km]?n|[km]?g|[ckm]?m|m?t|[km]?w|m?j|h|min|lux|gauss|ohm|s2|.+/.+"
"""Words of units that neither a command nor a rig's motion has, in small letters."""
GIVEN, BY_NO_LOAD = "given", "voltage over the speed without a load"


class FirstRig(NamedTuple):
    """A first rig file.

    Attributes:
        text: TOML text.
        notes: What the logs do not tell, a sentence each.
    """

    text: str
    notes: tuple[str, ...] = ()


def first_rig(
    paths: Sequence[str | PathLike[str]],
    datasheet: Datasheet,
    kind: str | None = None,
    model: MujocoJoint | None = None,
) -> FirstRig:
    """A first rig file for logs.

    Args:
        paths: The logs, of any layout; the first one says the columns.
        datasheet: What is known beforehand.
        kind: Kind of the rig, one of `rwjax.kinds.ONE_AXIS`; by the columns where none is given.
        model: The hinge of a MuJoCo model that the logs are of, from which the numbers are taken; the kind is then `joint`.

    Returns:
        Its text, and notes. Free numbers are estimated by a regression on the smoothed motion, where the logs allow it; else a comment
        says why not.

    Raises:
        LogError: A log cannot be read, has no column for the time, a command or a reading, or is of a rig with two axes; or it has no
            goal where the model's hinge has a servo.
    """
    sheet = read_sheet(paths[0])
    guessed = kind is None and model is None
    kind = "joint" if model else kind or kind_of(sheet, datasheet)
    check_columns(sheet, kind)
    lacks = _lacking(model) if model else ()
    columns = {*proposed(sheet, kind)} - {*lacks}
    _check_goal(sheet, kind, columns)
    section = _section(sheet, kind, lacks, datasheet.supply)
    name = Path(paths[0]).resolve().parent.name
    if datasheet.counts and not any(COLUMNS[column].encoder for column in columns if column in COLUMNS):
        raise LogError(f"{sheet.where(None)}: no column holds counts, and an angle needs no --counts: leave it out")
    numbers = model.numbers if model else _numbers(kind, datasheet, columns)
    unused = _unused(
        datasheet,
        lambda d: (model.numbers if model else _numbers(kind, d, columns), _section(sheet, kind, lacks, d.supply)),
    )
    for what, number in OWN_NUMBERS.items():
        if getattr(datasheet, what) is not None and not model and number not in numbers:
            option = what.replace("_", "-")
            raise LogError(
                f"{sheet.where(None)}: --{option} is given, and a first rig of kind `{kind}` has no {number}"
            )

    def text(numbers: dict[str, Known]) -> str:
        return _text(kind, guessed, "rig" if no_name(name) else name, numbers, datasheet, columns, section, model)

    said = (*unused, *_guessed_supply(datasheet, columns, numbers, section))
    rig = parse_rig(text(numbers))
    if model:
        _check_command(sheet, model, columns)
        read_logs(paths, rig)
        return _said("".join(f"# {note}\n" for note in model.notes) + text(numbers), said)
    logs = read_logs(paths, rig)
    if "goal_rad" in columns:
        head = "# No number is estimated yet: fill in what is known of the servo, then `rwjax check`.\n"
        return _said(head + text(numbers), said)
    K = numbers.get("motor.torque_constant")
    if kind == "joint" and WEIGHT not in numbers:
        weight = hanging(lambda more: parse_rig(text(numbers | more)), logs)
        numbers, logs, said = numbers | weight.numbers, weight.logs, (*said, *weight.notes)
        rig = parse_rig(text(numbers))
    try:
        found = first_estimates(rig, logs, numbers, by_no_load_speed=K is not None and K.why == BY_NO_LOAD)
    except InputError as why:
        return _said(f"# No number is estimated yet: {printable(str(why))}\n{text(numbers)}", said)
    return _said(text(found.numbers), said, found.notes)


def _said(text: str, said: tuple[str, ...], more: Sequence[str] = ()) -> FirstRig:
    """A first rig file with its notes: which of its numbers are guesses, those that no other note names among them."""
    rig = parse_rig(text)
    names = [name for name in rig.guessed if not any(f"`{name}`" in note for note in said)]
    names = [name for name in names if not name.startswith("columns.")]  # of a scale, whose supply's voltage is said
    free, fixed = ([name for name in names if (name in rig.free) == is_free] for is_free in (True, False))
    guesses = [f"guesses, which stay as they are: {', '.join(fixed)}; write the true ones"] if fixed else []
    guesses += [f"guesses, which a fit estimates: {', '.join(free)}"] if free else []
    return FirstRig(text, (*said, *guesses, *more))


def _section(sheet: Sheet, kind: str, lacks: Sequence[str], supply: float | None) -> str:
    """The section `[columns]`; none for files that have rwjax's own names."""
    if {*sheet.names} <= {*columns_of(kind)}:
        return ""
    return printable_lines(proposal(sheet, kind, lacks, supply))


def _guessed_supply(
    datasheet: Datasheet, columns: set[str], numbers: Mapping[str, Known], section: str
) -> tuple[str, ...]:
    """A sentence on the supply's voltage, where the file needs one that is neither given nor logged."""
    of_duty = "drive.supply" in numbers and "supply_V" not in columns
    if datasheet.supply or not (of_duty or SUPPLY_GUESSED in section):
        return ()
    where = "`drive.supply`" if of_duty else "`scale` under [columns]"
    return (
        f"--supply is not given: {SUPPLY_V:g} V in {where} is a guess; write the supply's voltage, or everything per volt is wrong",
    )


def _unused(datasheet: Datasheet, made: Callable[[Datasheet], object]) -> tuple[str, ...]:
    """A sentence on each number of the datasheet from which nothing is made: another value would leave the file as it is."""
    as_given, said = made(datasheet), []
    for name, value in datasheet._asdict().items():
        if name in OF_A_VALUE or value is None:
            continue
        if made(datasheet._replace(**{name: 2.0 * value or 1.0})) == as_given:
            more = SUPPLY_ALONE if name == "supply" else ""
            said.append(f"--{name.replace('_', '-')} is not used: no number of this file comes from it{more}")
    return tuple(said)


def check_columns(sheet: Sheet, kind: str) -> None:
    """Checks that a first rig file can be written for a table.

    Args:
        sheet: The columns of a log.
        kind: Kind of the rig.

    Raises:
        LogError: Where no column is taken for the time, a command or a reading, by a value that is no number, if there is one; and for
            logs in the thesis's layout, or of a rig with two axes.
    """
    second = [name for name in sheet.names if name in OF_TWO_AXES]
    one_axis = all(name.startswith("pitch") for name in second) and not any(n.startswith("yaw") for n in sheet.names)
    if second and one_axis and sheet.notes.get(LAYOUT[0]) == LAYOUT[1]:
        calls = ", ".join(f"`{name.replace('pitch', 'yaw')}` for `{name}`" for name in second)
        raise LogError(f"{sheet.where(None)}: `init` writes rigs with one axis, which is called yaw: write {calls}")
    if second and not one_axis:
        raise LogError(f"{sheet.where(None)}: a rig with two axes; `init` writes rigs with one command")
    if [*sheet.names] == [*THESIS_COLUMNS]:
        needed = 'pulse = "pwm_1"` and [drive] `pwm = { neutral_us = …, volts_per_us = … }`'
        raise LogError(
            f'{sheet.where(None)}: the thesis layout; write a rig file by hand with [columns] `position = "pos1"`, `{needed}'
        )
    found = proposed(sheet, "reaction") | (proposed(sheet, kind) if kind == "joint" else {})
    commands = {"voltage_V", "duty", "goal_rad", "command_A", "command_Nm"} & ({*found} | {*sheet.names})
    wanted = {
        "a time": "time_s" in found,
        "a command": bool(commands),
        "a reading": len({*found} - {"time_s"} - commands) > 0,
    }
    if all(wanted.values()):
        return
    taken = {one.column for one in found.values()}
    for column in sheet.names:
        if column not in taken:
            sheet.numbers([column])  # says where it is none
    what = " and ".join(name for name, there in wanted.items() if not there)
    by_hand = "" if wanted["a command"] else _commands_by_hand(sheet)
    raise LogError(
        f"{sheet.where(None)}: no column is taken for {what}; found {', '.join(sheet.names)}; say in a rig file what they are"
        f"{by_hand or ', under [columns]'}"
    )


def _check_goal(sheet: Sheet, kind: str, columns: set[str]) -> None:
    """Raises `LogError` where a goal is all that is commanded, and the rig takes none."""
    valid = {*commands_of(kind)}
    goal = proposed(sheet, "joint").get("goal_rad")
    if goal is not None and "goal_rad" not in valid and not valid & (columns | {*sheet.names}):
        raise LogError(
            f"{sheet.where(None)}: `{printable(goal.column)}` is the goal of a servo, which a `{kind}` rig does not take: a goal needs kind "
            f"{' or '.join(one for one in ONE_AXIS if 'goal_rad' in commands_of(one))}, and a `{kind}` a voltage or a duty"
        )


def _commands_by_hand(sheet: Sheet) -> str:
    """How a rig file says which column is the command: one for a torque, where a column's name says that it is one."""
    if (torque := next(filter(is_commanded_torque, sheet.names), None)) is None:
        return (
            ', under [columns], such as `voltage_V = "NAME"`: or duty, command_A (a current), command_Nm (a torque, kind = "joint") '
            f"or goal_rad (an angle that a servo is to reach){_platform_by_hand(sheet)}"
        )
    return f": `{printable(torque)}` looks like a commanded torque, which a joint alone takes: give --kind joint"


def _platform_by_hand(sheet: Sheet) -> str:
    """The lines that are a first rig file of a platform, where all but the command is taken for a column of one."""
    motion = proposed(sheet, "platform")
    if "time_s" not in motion or not {*COLUMNS} & {*motion}:
        return ""
    taken = {one.column for one in motion.values()}
    others = [name for name in sheet.names if name not in taken and name not in columns_of("platform")]
    found = {name: line for name in others if (line := _command_by_hand(sheet, name))}
    if not found:
        return ""
    command = next(iter(found.values())) if len(found) == 1 else 'voltage_V = "NAME"'
    percent = command.startswith("duty")
    what = "the scale" if ', scale = "' in command else "the unit V"
    guess = "; whether the column is the command is a guess" + ("" if percent else f", and so is {what}")
    lines = ", ".join([*(one.line.partition("   #")[0] for one in motion.values()), command])
    more = "`drive.supply = 12.0` (V, a guess), " if percent else ""
    more += "`encoder.counts_per_rev = 2048` (a guess), " if "yaw_counts" in motion else ""
    return (
        f'; a file with the lines `kind = "platform"`, `drive.gain = 1.0`, `axis.inertia = 0.1` (a guess), `axis.friction.viscous = 0.0`, '
        f'{more}`columns = {{ {printable(lines)} }}` and `fit.free = ["axis.inertia", "axis.friction.viscous"]` is a first rig{guess}'
    )


def _command_by_hand(sheet: Sheet, column: str) -> str:
    """The line of a column that may be a command under a name that says nothing; "" where its unit or its values say that it is none."""
    last, unit = re.split(r"[\s_\-.\[\]()]+", column.strip(" _-.[]()").lower())[-1], unit_by_name(column)
    of_other_unit = last != column.lower() and re.fullmatch(OTHER_UNIT, last)
    if unit not in ("", "percent", "V", "mV", "count") or of_other_unit or is_temperature(column):
        return ""
    try:
        values = sheet.numbers([column])[0]
    except LogError:
        return ""
    values = values[np.isfinite(values)]
    if not values.size or (unit != "percent" and not values.min() < 0.0 < values.max()):
        return ""
    return command_line(column, values, unit, None).line.partition("   #")[0]


def kind_of(sheet: Sheet, datasheet: Datasheet) -> str:
    """Kind of a rig by the names in its logs, by the columns of rwjax's that they are taken for, and by what is known of a motor.

    Args:
        sheet: The columns of a log.
        datasheet: What is known beforehand.

    Returns:
        One of `rwjax.kinds.ONE_AXIS`.
    """
    names, columns = {*sheet.names}, {*proposed(sheet, "reaction")}
    given = bool({"goal_rad", "command_Nm"} & {*proposed(sheet, "joint")})
    if names & {"position_rad", "command_Nm"}:
        return "joint"
    if "position_m" in names:
        return "platform"
    axis = any(name.startswith("yaw") for name in columns)
    if any(name.startswith("wheel") for name in columns):
        return "reaction" if axis else "wheel"
    if datasheet.gain:
        return "platform"
    if given:
        return "joint"
    yaw = any("yaw" in name.lower() for name in names)
    if datasheet.wheel_inertia:
        return "reaction" if yaw or datasheet.axis_inertia else "wheel"
    if columns & {"duty", "command_A", "current_A"} or (datasheet.of_a_motor and (yaw or datasheet.axis_inertia)):
        return "joint"
    return "wheel" if datasheet.of_a_motor else "platform"


def _numbers(kind: str, d: Datasheet, columns: set[str]) -> dict[str, Known]:
    """Every number of the first rig file, by its name."""
    weighed = _weighs_the_motor(kind, d, columns)
    found = _motor(kind, d, columns, weighed) if kind in MOTORED else {}
    if kind == "platform":
        found["drive.gain"] = _gain(d)
    if kind in WHEELED:
        J = d.wheel_inertia
        found["wheel.inertia"] = Known(J, GIVEN) if J else Known(1e-4, GUESS, free=True)
        told = "current_A" in columns or J is not None or not found["motor.torque_constant"].free
        found["motor.friction"] = Known(
            0.0, GUESS if told else f"{GUESS}: without the current it is one with the back-EMF", free=told
        )
    if "duty" in columns:
        found["drive.supply"] = Known(d.supply, GIVEN) if d.supply else Known(SUPPLY_V, f"{GUESS}, or --supply")
    if kind in TURNING:
        found["axis.inertia"] = Known(d.axis_inertia, GIVEN) if d.axis_inertia else _inertia(d)
        found["axis.friction.viscous"] = Known(0.01, GUESS, free=True)
        if kind == "joint":  # gears rub: without dry friction something else stands in for it
            found["axis.friction.coulomb"] = Known(0.01, GUESS, free=True)
        if kind == "joint" and d.mass and d.length:
            share, why = (
                (1.0, "of a bob, m g l") if d.bob else (0.5, "of a rod, m g l/2; of a bob at its end twice that")
            )
            why += ", fixed: it tells the torque constant" if weighed else ""
            weight = rounded(share * d.mass * GRAVITY * d.length)
            found["axis.gravity.torque"] = Known(weight, why, free=not weighed, by_mass=True)
            found["axis.gravity.angle"] = Known(0.0, f"0 where the {'bob' if d.bob else 'rod'} hangs down at angle 0")
    if "goal_rad" in columns:
        found = servo_numbers(
            found,
            inertia_known=bool(d.axis_inertia or (kind in WHEELED and d.wheel_inertia)),
            current="current_A" in columns,
            wheel_measured=bool({"wheel_rad_s", "wheel_rad", "wheel_counts"} & columns),
            kp=d.kp,
            kd=d.kd,
        )
    return found


def _weighs_the_motor(kind: str, d: Datasheet, columns: set[str]) -> bool:
    """Whether the weight of a joint's link is all that tells its motor's torques: a current, an inertia or the motor's numbers do so as well."""
    told = d.axis_inertia or _torque_constant(d) or {"current_A", "command_Nm", "goal_rad"} & columns
    return bool(kind == "joint" and d.mass and d.length and not told)


def _inertia(d: Datasheet) -> Known:
    """Inertia of what the axis carries, by its mass and length."""
    if not d.mass or not d.length:
        return Known(0.1, GUESS, free=True)
    share, why = (
        (1.0, "of a bob, m l²") if d.bob else (1.0 / 3.0, "of a rod, m l²/3; of a bob at its end three times that")
    )
    return Known(rounded(share * d.mass * d.length**2), why, free=True, by_mass=True)


def _gain(d: Datasheet) -> Known:
    """Gain of a platform's drive."""
    if d.gain:
        return Known(d.gain, GIVEN)
    if d.stall_torque and d.supply:
        return Known(rounded(d.stall_torque / d.supply), "stall torque over the voltage")
    if d.axis_inertia:
        return Known(1.0, f"{GUESS}: the inertia that is given tells it", free=True)
    return Known(1.0, "unknown: with 1, torques and inertias are in units of the drive's gain")


def _torque_constant(d: Datasheet) -> Known | None:
    """Torque constant by the datasheet, seen behind the gear; None where it does not tell it."""
    if d.torque_constant:
        return Known(d.torque_constant, GIVEN)
    if d.supply and d.no_load_speed:
        return Known(rounded(d.supply / d.no_load_speed), BY_NO_LOAD)
    if d.supply and d.stall_torque and d.resistance:
        found = rounded(d.stall_torque * d.resistance / d.supply)
        return Known(found, "stall torque times resistance over the voltage")
    return None


def _motor(kind: str, d: Datasheet, columns: set[str], weighed: bool) -> dict[str, Known]:
    """Torque constant and resistance, seen behind the gear; `weighed` where a link's weight tells the torques."""
    if "command_Nm" in columns:
        return {}
    current = "current_A" in columns
    scaled = bool(current or d.wheel_inertia or d.axis_inertia or weighed)
    told = scaled or kind == "wheel" or "wheel_rad_s" in columns
    K = _torque_constant(d) or Known(0.02, f"{GUESS}, or --torque-constant", free=told)
    if d.resistance:
        R = Known(d.resistance, GIVEN)
    elif d.supply and d.stall_torque:
        R = Known(rounded(K.value * d.supply / d.stall_torque), "torque constant times voltage over the stall torque")
    else:
        given = f"{GUESS}, or --resistance"
        by_voltage = current and "command_A" not in columns
        why = given if scaled else f"{given}: torques and inertias are as wrong as this is"
        R = Known(1.0, why, free=by_voltage)
    return {"motor.torque_constant": K, "motor.resistance": R}


def _text(
    kind: str,
    guessed: bool,
    name: str,
    numbers: dict[str, Known],
    datasheet: Datasheet,
    columns: set[str],
    section: str,
    model: MujocoJoint | None,
) -> str:
    """The rig file."""
    others = ", ".join(one for one in ONE_AXIS if one != kind)
    by = f"   # by columns and options; else --kind, one of {others}" if guessed else ""
    lines = [f'kind = "{kind}"{by}', f"name = {json.dumps(name, ensure_ascii=False)}"]
    for part in dict.fromkeys(key.rpartition(".")[0] for key in NUMBERS if key in numbers):
        lines += ["", f"[{part}]"]
        lines += _servo_choices(model) if part == SERVO else []
        lines += [
            numbers[key].line(key, "torque" if model else "voltage")
            for key in NUMBERS
            if key in numbers and key.rpartition(".")[0] == part
        ]
    lines += [] if "axis.inertia" not in numbers or "axis.gravity.torque" in numbers or model else OF_A_WEIGHT
    for column in (name for name in COLUMNS if name in columns):
        if on := COLUMNS[column].encoder:
            counts = (
                repr(datasheet.counts).removesuffix(".0")
                if datasheet.counts
                else "2048   # a guess: counted edges per turn"
            )
            lines += ["", f"[{encoder_section(on, kind)}]", f"counts_per_rev = {counts}"]
    for effect, given in (model.effects if model else {}).items():
        lines += ["", f'[effects."{effect}"]', *(f"{key} = {value!r}" for key, value in given.items())]
    lines += ["", *section.splitlines()] if section else []
    free = ", ".join(f'"{key}"' for key, known in numbers.items() if known.free)
    return "\n".join(
        [*lines, "", "[fit]", f"free = [{free}]   # estimated by `rwjax fit`; all else is taken as known", ""]
    )


def _servo_choices(model: MujocoJoint | None) -> list[str]:
    """What a servo's command is."""
    if model is None:
        return [
            'acts_on = "voltage"   # a guess: or "duty", "current", "torque"',
            "# limit = 12.0   # of the output, V: without it there is none",
            f"# period = {PERIOD:g}   # between ticks, s: what counts without it",
        ]
    return ['acts_on = "torque"', 'damping_on = "speed"']


def _lacking(model: MujocoJoint) -> tuple[str, ...]:
    """Columns that a model's hinge has nothing for: other commands than its actuator's, and without a motor the current."""
    motor = "motor.torque_constant" in model.numbers
    commands = {"goal_rad": model.servo, "voltage_V": motor and not model.servo, "duty": False}
    commands |= {"command_Nm": not motor and not model.servo, "command_A": False, "current_A": motor, "supply_V": False}
    return tuple(name for name, has in commands.items() if not has)


def _check_command(sheet: Sheet, model: MujocoJoint, columns: set[str]) -> None:
    """`LogError` where the log's command is not what the actuator of a model takes."""
    names, motor = columns | {*sheet.names}, "motor.torque_constant" in model.numbers
    wanted = {"goal_rad"} if model.servo else {"voltage_V"} if motor else {"command_Nm"}
    if not wanted & names:
        raise LogError(
            f"{sheet.where(None)}: the actuator of `{model.name}` takes {wanted.pop()}, and no column is taken for it; found "
            f"{', '.join(sheet.names)}"
        )
