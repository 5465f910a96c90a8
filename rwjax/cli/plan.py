"""The command that plans a campaign: which runs tell most about a rig, as large as its limits allow."""

import json
import math
import sys
from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.options import RATE, Json, Quiet, RigFile, finite, of_file, positive, results
from rwjax.errors import InputError

BY_HAND = {
    "platform": "with a known inertia added to the axis (`# add axis.inertia: 0.012` in its log): fixes gain over inertia",
    "reaction": "with a known inertia added to the axis (`# add axis.inertia: 0.012` in its log), and with the axis held",
    "wheel": "with the motor's terminals open after spin-up: friction without back-EMF",
}
"""Runs that need a hand at the rig, by its kind."""


def plan(
    rig: RigFile,
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the plan")] = Path("plan"),
    volts: Annotated[
        float | None, typer.Option(help="largest command, V; has to be given where the rig file has no `drive.pwm`")
    ] = None,
    amps: Annotated[float | None, typer.Option(help="largest current, A")] = None,
    rpm: Annotated[float | None, typer.Option(help="largest rate of the wheel, 1/min")] = None,
    rate: Annotated[float | None, typer.Option(help="largest rate of the axis, rad/s (a linear one: m/s)")] = None,
    travel: Annotated[
        str | None,
        typer.Option(
            metavar="ANGLE",
            help="largest way of the axis, either way of where the first run begins: rad (a linear one: m), or degrees with `deg` "
            "behind the number, such as 40deg",
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Plan the runs that tell most effects of RIG apart, within its limits; writes plan.toml and a CSV for each."""
    from rwjax.planning.campaign import recommend
    from rwjax.planning.envelope import LIMITS, envelope
    from rwjax.planning.files import Plan, as_document, replaced, write_plan
    from rwjax.report.plan import table
    from rwjax.rig.read import read_one_axis_rig

    way = None if travel is None else _travel(travel)
    options = {"volts": volts, "amps": amps, "rpm": rpm, "rate": rate, "travel": way}
    given = {name: value for name, value in options.items() if value is not None}
    finite(**given)
    positive(**given)
    wheel = None if rpm is None else rpm * RATE
    most = {"current_A": amps, "wheel_rad_s": wheel, "yaw_rad_s": rate, "yaw_rad": way}
    believed = read_one_axis_rig(rig)
    with of_file(rig):
        within = envelope(believed, volts, {name: value for name, value in most.items() if value is not None})
        runs, remarks = recommend(believed, within)
    found = Plan(believed.name, within.known, runs)
    with results(output) as folder:
        lost = replaced(folder, found.rig)
        written = write_plan(folder, found)
    if as_json:
        print(json.dumps(as_document(found), indent=1))
    else:
        print(table(found))
        print(
            f"{len(runs)} run{'s' * (len(runs) != 1)}, {found.seconds / 60.0:.1f} min without the waits between them; written to {written}"
        )
    if quiet:
        return
    if lost is not None:
        print(f"note: this replaces {lost}", file=sys.stderr)
    unlimited = [f"{LIMITS[name].option} ({LIMITS[name].words})" for name in within.limits if name not in within.known]
    if unlimited:
        print(f"note: no limit is known, and the volts alone bound it: {', '.join(unlimited)}", file=sys.stderr)
    if way is not None and travel is not None and way > 2.0 * math.pi and travel.strip()[-1:].isdigit():
        turns = way / (2.0 * math.pi)
        remarks = (
            f"--travel {travel} is rad, {turns:.3g} turns, if the axis turns; degrees are written --travel {travel}deg",
            *remarks,
        )
    for remark in (*remarks, f"worth a run by hand: {BY_HAND[believed.kind]}"):
        print(f"note: {remark}", file=sys.stderr)


def _travel(text: str) -> float:
    """What `--travel` says [rad]. Raises `InputError` for anything but a number, with `deg` or `°` behind it or not."""
    plain = text.strip()
    number = plain.removesuffix("deg").removesuffix("°")
    try:
        value = float(number)
    except ValueError:
        raise InputError(
            f"--travel {text}: has to be a number of rad, such as 0.7 (a linear axis: m), or of degrees, such as 40deg"
        ) from None
    return value if number == plain else math.radians(value)
