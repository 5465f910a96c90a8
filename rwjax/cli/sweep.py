"""The command `sweep`: step responses of the nonlinear closed loop over gains."""

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.control import (
    Kd,
    Kp,
    Late,
    Output,
    Rpm,
    Smooth,
    Volts,
    check_table,
    finite_json,
    on_edge,
    own_delay,
    pairs,
    remark,
    write_results,
)
from rwjax.cli.loop import Period, Seconds, Step, controller_of, reference_of
from rwjax.cli.options import Json, Quiet, RigFile, of_file
from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.control.sweep import GainSweep

Ki = Annotated[float, typer.Option(help="integral gain [V/(rad s)]")]


def sweep(
    rig_file: RigFile,
    kp: Kp = "5:100:39",
    kd: Kd = "1:40:40",
    ki: Ki = 0.0,
    step: Step = 10.0,
    seconds: Seconds = 10.0,
    volts: Volts = 10.0,
    rpm: Rpm = math.inf,
    period: Period = 0.01,
    late: Late = 0.0,
    smooth: Smooth = 0.02,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Step responses of RIG's nonlinear closed loop over gains: stick and slip, counts, sampling and limits.

    Example: `rwjax sweep fitted.toml -o sweep.csv`
    """
    import numpy as np

    from rwjax.control.sweep import sweep as run
    from rwjax.report.control import MAPS, draw_maps, response_columns
    from rwjax.report.table import csv
    from rwjax.rig.read import read_one_axis_rig

    check_table(output, rig_file)
    rig = read_one_axis_rig(rig_file)
    rows, cols = pairs(kp=kp, kd=kd)
    controller, timing = controller_of(rig, ki, volts, rpm, period, late, smooth)
    reference = reference_of(step, seconds, period)
    with of_file(rig_file):
        swept = run(rig, rows, cols, controller=controller, step=reference, timing=timing)
    found = swept.response
    if not np.isfinite(found.error).any():
        raise InputError(f"{rig_file}: every response leaves the range of numbers; check the rig's numbers and units")
    maps = {name: finite_json(np.asarray(getattr(found, field))) for name, (field, _, _) in MAPS.items()}
    answer = {"schema": "rwjax.sweep/1", "kp": rows.tolist(), "kd": cols.tolist(), **maps}
    figure = partial(draw_maps, rows, cols, found, f"responses to {step:g}°, limit {volts:g} V")
    table = csv(response_columns(rows, cols, found))
    written = write_results(output, table, figure, answer, as_json)
    notes = _notes(swept, {"kp": kp, "kd": kd})
    remark(quiet, *rig.cautions, *notes, *own_delay(rig), *written)


def _notes(swept: "GainSweep", given: dict[str, str]) -> list[str]:
    """How many pairs settle, which does so first, and whether it lies on the edge of a range that the user gave."""
    settling = swept.response.settling
    notes = [f"{swept.settled} of {settling.size} gain pairs settle within 2 % of the step"]
    if swept.fastest is None:
        notes.append(
            "none settles: where dry friction holds the axis off its angle, --ki helps, else a longer --seconds"
        )
    if swept.fastest is not None:
        i, j = swept.fastest
        notes.append(f"fastest: kp {swept.kp[i]:g}, kd {swept.kd[j]:g} after {float(settling[i, j]):.3g} s")
        notes += on_edge(given, (swept.kp, swept.kd), swept.fastest)
    return notes
