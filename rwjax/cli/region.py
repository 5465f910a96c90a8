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
    check_table,
    finite_json,
    own_delay,
    pairs,
    remark,
    timing_of,
    with_fit,
    write_results,
)
from rwjax.cli.options import Json, Quiet, RigFile, finite, of_file
from rwjax.errors import InputError, counted

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np

    from rwjax.control.criteria import ContinuousPoles, SampledPoles
    from rwjax.control.fit_estimate import FitEstimate
    from rwjax.control.region import Region
    from rwjax.rig.model import Rig

    Maps = dict[str, np.ndarray]

SMOOTH = 0.02
"""Time constant of the derivative's filter [s] where the user gives none."""
PLANTS = 1000
"""Plants that are drawn where the user gives no number of them [1]."""
SHARE, SLOWEST = "share of plants", "slowest_per_s"
Damping = Annotated[float, typer.Option(help="and with a damping ratio of at least this")]
Period = Annotated[float | None, typer.Option(help="of the loop as it runs: sampled at this period [s], held and late")]
Smooth = Annotated[
    float | None, typer.Option(help="time constant of the derivative's filter [s], with --period", show_default="0.02")
]
Margins = Annotated[bool, typer.Option("--margins", help="beside it, the margins of every pair that is in it")]
Slowest = Annotated[bool, typer.Option("--slowest", help="beside it, the real part of every pair's slowest pole [1/s]")]
Angle = Annotated[
    float, typer.Option(help="angle at which the axis is held [°]; of a linear axis 1° stands for 0.01745 m")
]
Without = Annotated[
    str | None, typer.Option(metavar="EFFECT", help="beside it, the region of the rig without this effect")
]


def region(
    rig_file: RigFile,
    kp: Kp = "0:100:101",
    kd: Kd = "0:100:101",
    sigma: Sigma = 0.5,
    damping: Damping = 0.0,
    period: Period = None,
    late: Late = 0.0,
    smooth: Smooth = None,
    margins: Margins = False,
    slowest: Slowest = False,
    angle: Angle = 0.0,
    without: Without = None,
    fit: FitFile = None,
    plants: Plants = None,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """PD gains of RIG's axis that put every pole of the closed loop left of -sigma; --late and --smooth act with --period.

    Example: `rwjax region fitted.toml --sigma 0.5 -o region.csv`
    """
    from rwjax.control.region import region_of
    from rwjax.report.region import draw_region, region_columns
    from rwjax.report.table import csv
    from rwjax.rig.read import read_one_axis_rig

    finite(sigma=sigma, angle=angle, damping=damping)
    if not 0.0 <= damping < 1.0:
        raise InputError(f"--damping {damping:g}: has to lie between 0 and below 1")
    check_table(output, rig_file, fit)
    rig = read_one_axis_rig(rig_file)
    gains = pairs(kp=kp, kd=kd)
    rig, estimate, fit_notes = with_fit(rig_file, rig, fit, plants)
    criterion = _criterion(rig, sigma, damping, period, late, smooth, math.radians(angle))
    with of_file(rig_file):
        found = region_of(rig, criterion, *gains)
        distances = (found.margins() if margins else {}) | ({SLOWEST: found.slowest()} if slowest else {})
        beside = _beside(found, without, estimate, plants or PLANTS)
    table, answer = csv(region_columns(found, beside | distances)), _answer(found, period, beside, distances)
    written = write_results(output, table, lambda: draw_region(found, beside), answer, as_json)
    notes = _notes(found, beside, distances, plants or PLANTS)
    remark(quiet, *rig.cautions, *fit_notes, *notes, *_left_out(rig, found), *written)


def _criterion(
    rig: "Rig", sigma: float, damping: float, period: float | None, late: float, smooth: float | None, angle: float
) -> "ContinuousPoles | SampledPoles":
    """What is asked of the poles: of the continuous loop, or with a period of the loop as it runs."""
    from rwjax.control.criteria import ContinuousPoles, SampledPoles

    if period is None:
        if late != 0.0 or smooth is not None:
            given = f"--late {late:g}" if late != 0.0 else f"--smooth {smooth:g}"
            raise InputError(f"{given}: is of the loop as it runs; give --period, or leave it out")
        return ContinuousPoles(sigma, damping, angle)
    if damping > 0.0:
        raise InputError(f"--damping {damping:g}: is of the continuous loop; leave it or --period out")
    smooth = SMOOTH if smooth is None else smooth
    return SampledPoles(sigma, timing_of(rig, period, late, smooth), smooth, angle)


def _beside(region: "Region", without: str | None, estimate: "FitEstimate | None", plants: int) -> "Maps":
    """What stands beside the region: that of the rig without an effect, and the share of plants drawn from a fit."""
    from rwjax.control.fit_estimate import draw_plants
    from rwjax.control.region import region_of

    found: Maps = {}
    if without is not None:
        rest = region_of(_without(region.rig, without), region.criterion, region.kp, region.kd)
        found[f"without {without}"] = rest.stable.astype(float)
    if estimate is not None:
        found[SHARE] = region.share_of_plants(draw_plants(region.rig, estimate, plants))
    return found


def _without(rig: "Rig", effect: str) -> "Rig":
    if effect not in rig.effects:
        held = ", ".join(rig.effects) or "none"
        raise InputError(f"--without {effect}: the rig file holds no such effect; it holds {held}")
    return replace(rig, effects={name: numbers for name, numbers in rig.effects.items() if name != effect})


def _answer(found: "Region", period: float | None, beside: "Maps", distances: "Maps") -> dict:
    """The result as JSON holds it."""
    return {
        "schema": "rwjax.region/1",
        "kp": found.kp.tolist(),
        "kd": found.kd.tolist(),
        "sigma": found.sigma,
        "damping": found.damping,
        "period": period,
        "stable": found.stable.astype(int).tolist(),
        "share": found.share,
        "left_out": list(found.plant.hidden),
        **{name.replace(" ", "_"): value.tolist() for name, value in beside.items()},
        **{name: finite_json(value) for name, value in distances.items()},
    }


def _notes(found: "Region", beside: "Maps", distances: "Maps", plants: int) -> list[str]:
    """How many gain pairs do it, how many are judged otherwise beside it, and which has the largest modulus margin."""
    import numpy as np

    notes = [f"{int(found.stable.sum())} of {found.stable.size} gain pairs {found.criterion.condition}"]
    if found.sigma < 0.0:
        notes.append("sigma is negative: loops that are not stable count too; 0 or more asks for stable ones")
    for name, value in beside.items():
        every, differ = int(np.sum(value == 1.0)), int(np.sum((value == 1.0) != found.stable))
        what = f"{every} do so for all {plants} plants drawn" if name == SHARE else f"{name}: {every}"
        notes.append(f"{what}; {counted(differ, 'pair')} {'is' if differ == 1 else 'are'} judged otherwise")
    if "modulus" in distances:
        notes += _best_pair(found, "largest modulus margin: {:.3g}", distances["modulus"], np.nanargmax)
    if SLOWEST in distances:
        notes += _best_pair(found, "fastest loop: slowest pole at {:.3g} 1/s", distances[SLOWEST], np.nanargmin)
    return notes


def _best_pair(found: "Region", words: str, values: "np.ndarray", pick: "Callable[[np.ndarray], np.intp]") -> list[str]:
    """A line on the pair of the region whose value is picked, if there is one."""
    import numpy as np

    within = np.where(found.stable & np.isfinite(values), values, np.nan)
    if np.isnan(within).all():
        return []
    i, j = np.unravel_index(pick(within), within.shape)
    return [f"{words.format(within[i, j])} at kp {found.kp[i]:g}, kd {found.kd[j]:g}"]


def _left_out(rig: "Rig", found: "Region") -> list[str]:
    """What of the rig the linear loop does not hold, and what it takes otherwise."""
    from rwjax.control.linear import left_out_effects, linearisation_notes

    sampled = found.period > 0.0
    notes = ["left out: the conserved momentum's pole at 0, which no gain moves"] if found.plant.hidden else []
    lacking = left_out_effects(rig, sampled=sampled)
    notes += [f"left out: {', '.join(lacking)}, which no transfer function holds"] if lacking else []
    delay = own_delay(rig)
    notes += delay if sampled or not delay else ["with --period the rig's own delays are in the loop"]
    return [*notes, *linearisation_notes(rig)]
