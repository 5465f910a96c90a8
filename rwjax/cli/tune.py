"""The command `tune`: gains of the largest worst-case margin, then tuned through the nonlinear closed loop."""

import math
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.control import (
    FitFile,
    Late,
    Plants,
    Rpm,
    Sigma,
    Smooth,
    Volts,
    finite_json,
    own_delay,
    remark,
    with_fit,
)
from rwjax.cli.loop import Period, Seconds, Step, controller_of, reference_of
from rwjax.cli.options import Json, Quiet, RigFile, finite, of_file, span
from rwjax.cli.progress import progress
from rwjax.cli.terminal import document, say
from rwjax.errors import InputError, in_two_digits
from rwjax.report.answer import json_text

if TYPE_CHECKING:
    from rwjax.control.gain_design import DesignedController, GainDesign

PLANTS = 200
"""Plants that are drawn where the user gives no number of them [1]."""
KpRange = Annotated[str, typer.Option(metavar="FROM:TO", help="where gains are looked for [V/rad]")]
KdRange = Annotated[str, typer.Option(metavar="FROM:TO", help="where gains are looked for [V s/rad]")]
Ki = Annotated[float, typer.Option(help="integral gain to begin with [V/(rad s)]; 0: none")]
Least = Annotated[float, typer.Option(help="modulus margin that the tuned loop keeps")]
Forward = Annotated[float, typer.Option(help="share of the breakaway friction that is fed forward")]
Dead = Annotated[float, typer.Option(help="error within which nothing is fed forward [°]")]


def tune(
    rig_file: RigFile,
    kp: KpRange = "0:100",
    kd: KdRange = "0:100",
    ki: Ki = 0.0,
    sigma: Sigma = 0.5,
    fit: FitFile = None,
    plants: Plants = None,
    least: Least = 0.5,
    forward: Forward = 0.0,
    dead: Dead = 0.2,
    step: Step = 10.0,
    seconds: Seconds = 10.0,
    volts: Volts = 10.0,
    rpm: Rpm = math.inf,
    period: Period = 0.01,
    late: Late = 0.0,
    smooth: Smooth = 0.02,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Gains for RIG's axis: tuned through the nonlinear closed loop, and those of the largest worst-case margin; first those that settle.

    Example: `rwjax tune fitted.toml --fit fit.json`
    """
    from rwjax.control.fit_estimate import draw_plants
    from rwjax.control.gain_design import GainRequirement
    from rwjax.control.gain_design import tune as run
    from rwjax.rig.read import read_one_axis_rig

    rig = read_one_axis_rig(rig_file)
    _check(sigma, dead, forward, least)
    rows, cols = span("--kp", kp), span("--kd", kd)
    controller, timing = controller_of(rig, ki, volts, rpm, period, late, smooth)
    reference = reference_of(step, seconds, period)
    rig, estimate, fit_notes = with_fit(rig_file, rig, fit, plants)
    with of_file(rig_file), progress(quiet, lines=True) as show:
        design = run(
            rig,
            GainRequirement(tuple(rows.tolist()), tuple(cols.tolist()), sigma, least),
            controller=controller._replace(deadband=math.radians(dead)),
            friction_share=forward,
            step=reference,
            timing=timing,
            thetas=draw_plants(rig, estimate, plants or PLANTS) if estimate is not None else None,
            progress=show,
        )
    laws = {"robust": _shown(design.robust), "tuned": _shown(design.tuned)}
    answer = json_text({"schema": "rwjax.tune/1", "plants": design.plants, **_stable(design), **laws})
    if as_json:
        document(answer + "\n")
        return
    say("\n".join(_lines(laws, {"robust": design.robust.why, "tuned": design.tuned.why}, _help(forward))))
    about = _about(design.plants, sigma, step, bool(ki), bool(fit))
    remark(quiet, *rig.cautions, *fit_notes, about, *_notes(design, least), *own_delay(rig))


def _stable(design: "GainDesign") -> dict[str, float]:
    return {"stable_with_tuned": design.tuned.robustness.stable}


def _about(plants: int, sigma: float, step: float, integral: bool, fitted: bool) -> str:
    """What the robust and the tuned gains are."""
    over = f"worst-case margin over {plants} plants" if plants > 1 else "margin on the rig alone"
    settle = "" if integral else ", of those that settle or stay least off"
    return (
        f"robust: kp and kd of the largest {over}, every pole left of -{sigma:g} 1/s{' without ki' if integral else ''}{settle} "
        f"(a larger --sigma makes the loop faster); tuned: a step of {step:g}° on the rig{' as fitted' if fitted else ' as given'}"
    )


def _check(sigma: float, dead: float, forward: float, least: float) -> None:
    finite(sigma=sigma, dead=dead)
    if sigma < 0.0:
        raise InputError(f"--sigma {sigma:g}: must not be negative, the loop has to be stable to be tuned")
    if not 0.0 <= forward <= 1.0:
        raise InputError(f"--forward {forward:g}: has to lie between 0 and 1; more makes the loop oscillate")
    if not 0.0 < least < 1.0:
        raise InputError(f"--least {least:g}: has to lie between 0 and 1")


def _shown(design: "DesignedController") -> dict:
    """A controller's gains, step response and modulus margin, as JSON holds them."""
    import numpy as np

    gains = {key: float(getattr(design.controller, key)) for key in ("kp", "ki", "kd")}
    seen = {key: float(value) for key, value in design.response._asdict().items()}
    never = {"settling": finite_json(np.asarray(design.response.settling))}
    return {**gains, **seen, **never, "modulus": design.robustness.modulus}


def _help(forward: float) -> str:
    """What is advised where friction lets no gains settle."""
    integral = "--ki with a larger --sigma"
    return f"{integral} helps against friction" if forward else f"--forward 0.8, or {integral}, help against friction"


def _lines(laws: dict[str, dict], why: dict[str, str], against_friction: str) -> list[str]:
    """A line for each controller, first those that settle; where one does not, why, and which to take instead."""
    from rwjax.control.unsettled import FRICTION

    ordered = sorted(laws.items(), key=lambda law: (law[1]["settling"] is None, abs(law[1]["error"])))
    best, found = ordered[0]
    settled = f"; take the {best} ones"
    help_of = {name: f"; {against_friction}" if reason.startswith(FRICTION) else "" for name, reason in why.items()}
    instead = dict.fromkeys(why, settled) if found["settling"] is not None else help_of
    return [_line(name, law, f": {why[name]}{instead[name]}" if why[name] else "") for name, law in ordered]


def _line(name: str, found: dict, why: str) -> str:
    """A controller's gains and step response, with what is said where it does not settle."""
    settles = "does not settle" if found["settling"] is None else f"settles in {found['settling']:.3g} s"
    return (
        f"{name}: kp {found['kp']:.4g} V/rad, ki {found['ki']:.4g} V/(rad s), kd {found['kd']:.4g} V s/rad; modulus margin "
        f"{found['modulus']:.2f}; {settles}, overshoot {in_two_digits(100.0 * found['overshoot'])} %, stays "
        f"{math.degrees(abs(found['error'])):.2g}° off{why}"
    )


def _notes(design: "GainDesign", least: float) -> list[str]:
    """On the plants, and on a margin that could not be kept."""
    notes = []
    if design.plants > 1:
        notes.append(
            f"modulus margin: the worst of these plants; with the tuned gains {100.0 * design.tuned.robustness.stable:.4g} % of them are stable"
        )
    if design.least_modulus < least:
        notes.append(f"margin kept on the rig alone: {design.least_modulus:.2f}; the robust gains have no {least:g}")
    return notes
