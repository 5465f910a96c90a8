"""The command `dump`: the fastest stop of the wheel in which static friction holds the axis."""

import math
from functools import partial
from typing import Annotated

import typer

from rwjax.cli.control import Output, Volts, check_table, remark, write_results
from rwjax.cli.manoeuvre import Amps, delay_note, limits_of, of_rig_or_option
from rwjax.cli.options import RATE, Json, Quiet, RigFile, finite, positive
from rwjax.cli.progress import progress

Spin = Annotated[float, typer.Option(help="rate of the wheel [1/min]")]
Margin = Annotated[float, typer.Option(help="share of the breakaway torque to use")]


def dump(
    rig_file: RigFile,
    spin: Spin,
    volts: Volts = 10.0,
    amps: Amps = math.inf,
    margin: Margin = 0.9,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """The fastest stop of RIG's wheel in which static friction holds the axis.

    Example: `rwjax dump yaw.toml --spin 4000`
    """
    import numpy as np

    from rwjax.control.momentum_dump import dump as run
    from rwjax.report.control import course_columns, draw_courses
    from rwjax.report.table import csv
    from rwjax.rig.read import read_one_axis_rig

    finite(spin=spin, margin=margin)
    positive(margin=margin)
    check_table(output, rig_file)
    rig, limits = read_one_axis_rig(rig_file), limits_of(volts, amps, math.inf)
    with of_rig_or_option(rig_file), progress(quiet, lines=True) as show:
        found = run(rig, spin * RATE, limits, margin, show)
    columns = course_columns(found.best)
    moved = math.degrees(float(np.max(np.abs(np.asarray(found.best.angle)))))
    answer = {
        "schema": "rwjax.dump/1",
        "bound_s": found.bound,
        "least_time_s": found.time,
        "delay_s": found.delay,
        "moved_deg": moved,
        **{name: value.tolist() for name, value in columns.items()},
    }
    figure = partial(draw_courses, {f"from {spin:g} 1/min": found.best}, "the wheel stops, the axis does not move")
    written = write_results(output, csv(columns), figure, answer, as_json)
    bound = (
        f"with a share of {margin:g} of the breakaway torque no command does it in less than {found.bound:.3f} s; "
        if found.bound
        else ""
    )
    line = f"the wheel stands after {found.time:.3f} s; {bound}the axis moves by {moved:.2g}°"
    remark(quiet, line, *delay_note(found.delay), *written)
