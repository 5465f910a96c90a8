"""The command `plan`: which runs tell most about a rig, as large as its limits allow."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import RATE, Json, Quiet, RigFile, finite, of_file, positive
from rwjax.cli.result_folder import ResultFolder
from rwjax.cli.terminal import document, next_command, note, say
from rwjax.errors import InputError
from rwjax.kinds import beyond
from rwjax.report.answer import json_text

if TYPE_CHECKING:
    from rwjax.planning.envelope import Envelope

BY_HAND = {
    "joint": "with a known inertia added to the link (`# add axis.inertia: 0.012` in its log), and let go with torque off (`enabled`)",
    "platform": "with a known inertia added to the axis (`# add axis.inertia: 0.012` in its log): fixes gain over inertia",
    "reaction": "with a known inertia added to the axis (`# add axis.inertia: 0.012` in its log), and with the axis held",
    "wheel": "with the motor's terminals open after spin-up: friction without back-EMF",
}
"""Runs that need a hand at the rig, by its kind."""

Output = Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the plan")]
Volts = Annotated[
    float | None,
    typer.Option(
        help="largest command, V; has to be given where the rig file has neither `drive.pwm` nor `drive.supply`"
    ),
]
Goal = Annotated[
    str | None,
    typer.Option(
        metavar="ANGLE",
        help="largest goal of the rig's servo, either way of 0: the runs are goals; rad, or degrees with `deg` behind the number",
    ),
]
Amps = Annotated[float | None, typer.Option(help="largest current, A")]
Rpm = Annotated[float | None, typer.Option(help="largest rate of the wheel, 1/min")]
Rate = Annotated[float | None, typer.Option(help="largest rate of the axis, rad/s (a linear one: m/s)")]
Travel = Annotated[
    str | None,
    typer.Option(
        metavar="ANGLE",
        help="largest way of the axis, either way of where the first run begins: rad (a linear one: m), or degrees with `deg` "
        "behind the number, such as 40deg",
    ),
]


def plan(
    rig_file: RigFile,
    output: Output = Path("plan"),
    volts: Volts = None,
    amps: Amps = None,
    rpm: Rpm = None,
    rate: Rate = None,
    travel: Travel = None,
    goal: Goal = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Plan the runs that tell most effects of RIG apart, within its limits; writes plan.toml and a CSV for each.

    Example: `rwjax plan rig.toml --volts 12 -o plan`
    """
    from rwjax.planning.campaign import recommend
    from rwjax.planning.envelope import envelope
    from rwjax.planning.files import Plan, as_document, clear_plan, replaced, write_plan
    from rwjax.report.plan import table
    from rwjax.rig.read import read_one_axis_rig

    angle = None if travel is None else _angle("travel", travel)
    largest = None if goal is None else _angle("goal", goal)
    limits = _limits(volts=volts, amps=amps, rpm=rpm, rate=rate, travel=angle)
    _limits(goal=largest)
    if goal is not None and volts is not None:
        raise InputError("--goal and --volts: the runs are goals of the servo or voltages; leave one out")
    rig = read_one_axis_rig(rig_file)
    target = ResultFolder(output, clear_plan, (rig_file,))
    target.check()
    lost = replaced(output, rig.name)
    with of_file(rig_file):
        within = envelope(rig, volts, limits, largest)
        runs, remarks = recommend(rig, within)
    found = Plan(rig.name, within.known, runs)
    answer = json_text(as_document(found), indent=1)
    with target.renewed() as folder:
        written = output / write_plan(folder, found).name
    if as_json:
        document(answer + "\n")
    else:
        say(
            f"{table(found)}\n{len(runs)} run{'s' * (len(runs) != 1)}, {found.seconds / 60.0:.1f} min without the waits between them; "
            f"written to {written}\nrecord them, then look at their logs\n{next_command('check', rig_file, 'LOGS')}"
        )
    if quiet:
        return
    replaces = [] if lost is None else [f"this replaces {lost}"]
    by_hand = f"worth a run by hand: {BY_HAND[rig.kind]}"
    note(*replaces, *_unlimited(within), *_turns(travel, angle), *remarks, by_hand)


def _limits(**options: float | None) -> dict[str, float]:
    """The limits that the user gave, by the column of the output that they bound, in SI units."""
    given = {name: value for name, value in options.items() if value is not None}
    finite(**given)
    positive(**given)
    known = {
        "volts": ("voltage_V", "V", 1.0),
        "amps": ("current_A", "A", 1.0),
        "rpm": ("wheel_rad_s", "rad/s", RATE),
        "rate": ("yaw_rad_s", "rad/s", 1.0),
        "travel": ("yaw_rad", "rad", 1.0),
        "goal": ("goal_rad", "rad", 1.0),
    }
    for name, value in given.items():
        if limits := beyond(value * known[name][2], known[name][1], "positive"):
            raise InputError(f"--{name} {value:g}: {limits}")
    return {known[name][0]: value * known[name][2] for name, value in given.items() if name != "volts"}


def _unlimited(within: "Envelope") -> list[str]:
    from rwjax.planning.envelope import LIMITS

    names = [f"{LIMITS[name].option} ({LIMITS[name].words})" for name in within.limits if name not in within.known]
    bound = "the volts alone bound" if within.input == "voltage_V" else "the goal alone bounds"
    return [f"no limit is known of {', '.join(names)}; {bound} it"] if names else []


def _turns(travel: str | None, angle: float | None) -> list[str]:
    """A line where a travel of more than a turn was given without a unit: it may be meant in degrees."""
    if travel is None or angle is None or angle <= 2.0 * math.pi or not travel.strip()[-1:].isdigit():
        return []
    turns = angle / (2.0 * math.pi)
    return [f"--travel {travel} is rad, {turns:.3g} turns, if the axis turns; degrees are written --travel {travel}deg"]


def _angle(option: str, text: str) -> float:
    """What `--travel` or `--goal` says [rad]. Raises `InputError` for anything but a number, with `deg` or `°` behind it or not."""
    plain = text.strip()
    number = plain.removesuffix("deg").removesuffix("°")
    try:
        value = float(number)
    except ValueError:
        raise InputError(
            f"--{option} {text}: has to be a number of rad, such as 0.7 (a linear axis: m), or of degrees, such as 40deg"
        ) from None
    return value if number == plain else math.radians(value)
