"""The command `region`: which gains put every pole where it should be."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.control import (
    FitFile,
    Kd,
    Kp,
    Late,
    Output,
    Plants,
    Sigma,
    own_delay,
    pairs,
    plain,
    say,
    timing_of,
    with_fit,
    write,
)
from rwjax.cli.options import Json, Quiet, RigFile, finite, of_file
from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.rig.model import Rig


def _without(rig: "Rig", effect: str) -> "Rig":
    if effect not in rig.effects:
        held = ", ".join(rig.effects) or "none"
        raise InputError(f"--without {effect}: the rig file holds no such effect; it holds {held}")
    return replace(rig, effects={name: numbers for name, numbers in rig.effects.items() if name != effect})


def region(
    rig: RigFile,
    kp: Kp = "0:100:101",
    kd: Kd = "0:100:101",
    sigma: Sigma = 0.5,
    damping: Annotated[float, typer.Option(help="and with a damping ratio of at least this")] = 0.0,
    period: Annotated[
        float | None, typer.Option(help="of the loop as it runs: sampled at this period [s], held and late")
    ] = None,
    late: Late = 0.0,
    smooth: Annotated[
        float | None,
        typer.Option(help="time constant of the derivative's filter [s], with --period", show_default="0.02"),
    ] = None,
    margins: Annotated[
        bool, typer.Option("--margins", help="beside it, the margins of every pair that is in it")
    ] = False,
    angle: Annotated[
        float, typer.Option(help="angle at which the axis is held [°]; of a linear axis 1° stands for 0.01745 m")
    ] = 0.0,
    without: Annotated[
        str | None, typer.Option(metavar="EFFECT", help="beside it, the region of the rig without this effect")
    ] = None,
    fit: FitFile = None,
    plants: Plants = 1000,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """PD gains of RIG's axis that put every pole of the closed loop left of -sigma; --late and --smooth act with --period."""
    import numpy as np

    from rwjax.control.criteria import ContinuousPoles, SampledPoles
    from rwjax.control.fit_estimate import draw_plants
    from rwjax.control.linear import left_out_effects, linearisation_notes
    from rwjax.control.region import region_of
    from rwjax.report.control import csv
    from rwjax.report.region import columns, draw_region
    from rwjax.rig.read import read_one_axis_rig

    finite(sigma=sigma, angle=angle, damping=damping)
    if not 0.0 <= damping < 1.0:
        raise InputError(f"--damping {damping:g}: has to lie between 0 and below 1")
    believed, held = read_one_axis_rig(rig), math.radians(angle)
    gains = pairs(kp=kp, kd=kd)
    believed, spread, said = with_fit(rig, believed, fit)
    if period is None and (late != 0.0 or smooth is not None):
        given = f"--late {late:g}" if late != 0.0 else f"--smooth {smooth:g}"
        raise InputError(f"{given}: is of the loop as it runs; give --period, or leave it out")
    smooth = 0.02 if smooth is None else smooth
    if period is None:
        asked = ContinuousPoles(sigma, damping, held)
    elif damping > 0.0:
        raise InputError(f"--damping {damping:g}: is of the continuous loop; leave it or --period out")
    else:
        asked = SampledPoles(sigma, timing_of(believed, period, late, smooth), smooth, held)
    beside: dict[str, np.ndarray] = {}
    with of_file(rig):
        found = region_of(believed, asked, *gains)
        borne = found.margins() if margins else {}
        if without is not None:
            rest = region_of(_without(believed, without), asked, *gains)
            beside[f"without {without}"] = rest.stable.astype(float)
        if spread is not None:
            beside["share of plants"] = found.share_of_plants(draw_plants(believed, spread, plants))
    answer = {
        "schema": "rwjax.region/1",
        "kp": found.kp.tolist(),
        "kd": found.kd.tolist(),
        "sigma": sigma,
        "damping": damping,
        "period": period,
        "stable": found.stable.astype(int).tolist(),
        "share": found.share,
        "left_out": list(found.plant.hidden),
        **{name.replace(" ", "_"): value.tolist() for name, value in beside.items()},
        **{name: plain(value) for name, value in borne.items()},
    }
    inputs = (rig,) if fit is None else (rig, fit)
    written = write(
        inputs, output, csv(columns(found, beside | borne)), lambda: draw_region(found, beside), answer, as_json
    )
    notes = [f"{int(found.stable.sum())} of {found.stable.size} gain pairs {found.criterion.condition}"]
    for name, value in beside.items():
        every, differ = int(np.sum(value == 1.0)), int(np.sum((value == 1.0) != found.stable))
        what = f"{every} do so for all {plants} plants drawn" if name == "share of plants" else f"{name}: {every}"
        notes.append(f"{what}; {differ} pairs are judged otherwise")
    if borne and np.isfinite(borne["modulus"]).any():
        i, j = np.unravel_index(np.nanargmax(borne["modulus"]), found.stable.shape)
        notes.append(f"largest modulus margin: {borne['modulus'][i, j]:.3g} at kp {gains[0][i]:g}, kd {gains[1][j]:g}")
    notes += ["left out: the conserved momentum's pole at 0, which no gain moves"] if found.plant.hidden else []
    lacking = left_out_effects(believed, sampled=period is not None)
    notes += [f"left out: {', '.join(lacking)}, which no transfer function holds"] if lacking else []
    late_rig = own_delay(believed)
    notes += late_rig if period is not None or not late_rig else ["with --period the rig's own delays are in the loop"]
    say(quiet, *said, *notes, *linearisation_notes(believed), *written)
