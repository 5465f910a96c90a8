"""The command `slew`: the fastest turn of the axis from rest to rest."""

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.control import Output, Rpm, Volts, check_table, remark, write_results
from rwjax.cli.manoeuvre import Amps, Degrees, delay_note, limits_of, of_rig_or_option
from rwjax.cli.options import RATE, Json, Quiet, RigFile, finite
from rwjax.cli.progress import progress

if TYPE_CHECKING:
    from rwjax.control.slew import Slew

Spin = Annotated[float, typer.Option(help="rate of the wheel beforehand [1/min]")]


def slew(
    rig_file: RigFile,
    angle: Degrees,
    volts: Volts = 10.0,
    amps: Amps = math.inf,
    rpm: Rpm = math.inf,
    spin: Spin = 0.0,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """The fastest turn of RIG's axis from rest to rest, and what the ideal on-off law makes of it.

    Example: `rwjax slew yaw.toml --angle 45 --amps 3 --rpm 4000`
    """
    from rwjax.control.slew import slew as run
    from rwjax.report.control import course_columns, draw_courses
    from rwjax.report.table import csv
    from rwjax.rig.read import read_one_axis_rig

    finite(angle=angle, spin=spin)
    check_table(output, rig_file)
    rig, limits = read_one_axis_rig(rig_file), limits_of(volts, amps, rpm)
    with of_rig_or_option(rig_file), progress(quiet, lines=True) as show:
        found = run(rig, math.radians(angle), limits, spin * RATE, show)
    ideal, columns = found.ideal, course_columns(found.best)
    answer = {
        "schema": "rwjax.slew/1",
        "ideal": {"ramp_s": ideal.ramp, "hold_s": ideal.hold, "time_s": ideal.time, "wheel_rad_s": ideal.top},
        "miss_deg": math.degrees(found.miss),
        "least_time_s": found.time,
        "delay_s": found.delay,
        **{name: value.tolist() for name, value in columns.items()},
    }
    courses = {"fastest on the plant": found.best, "ideal on-off law": found.followed}
    figure = partial(draw_courses, courses, f"{angle:g}° slew")
    written = write_results(output, csv(columns), figure, answer, as_json)
    remark(quiet, *_notes(found, angle), *delay_note(found.delay), *written)


def _notes(found: "Slew", angle: float) -> list[str]:
    ideal, miss = found.ideal, math.degrees(found.miss)
    return [
        f"ideal on-off law, no friction, with the torque that the motor has left at {found.top / RATE:.0f} 1/min: {ideal.time:.3f} s "
        f"({ideal.ramp:.3f} up, {ideal.hold:.3f} held, {ideal.ramp:.3f} down), wheel to {ideal.top / RATE:.0f} 1/min; on this rig it ends {abs(miss):.3g}° {'short' if miss * angle < 0.0 else 'beyond'}",
        f"fastest on this rig: {found.time:.3f} s; the wheel goes on at {float(found.best.wheel[-1]) / RATE:.0f} 1/min",
    ]
