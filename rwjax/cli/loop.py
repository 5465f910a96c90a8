"""The commands that run the nonlinear loop of a rig's axis: `sweep` and `tune`."""

import json
import math
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.control import (
    FitFile,
    Kd,
    Kp,
    Late,
    Output,
    Plants,
    Rpm,
    Sigma,
    Smooth,
    Volts,
    own_delay,
    pairs,
    plain,
    say,
    timing_of,
    with_fit,
    write,
)
from rwjax.cli.options import RATE, Json, Quiet, RigFile, finite, of_file, positive, span
from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.control.controller import Controller, LoopTiming
    from rwjax.control.response import StepReference
    from rwjax.rig.model import Rig

Period = Annotated[float, typer.Option(help="sample time of the controller [s]")]
Ki = Annotated[float, typer.Option(help="integral gain [V/(rad s)]")]
Step = Annotated[float, typer.Option(help="step of the reference [°]")]
Seconds = Annotated[float, typer.Option(help="length of a response [s]")]


def _loop(
    rig: "Rig", ki: float, volts: float, rpm: float, period: float, late: float, smooth: float
) -> "tuple[Controller, LoopTiming]":
    """What a controller's options say, its gains but the integral one left at 0."""
    from rwjax.control.controller import Controller

    finite(ki=ki, volts=volts)
    positive(volts=volts, rpm=rpm)
    if ki < 0.0:
        raise InputError("--ki: must not be negative")
    timing = timing_of(rig, period, late, smooth)
    return Controller(0.0, ki=ki, filter_time=smooth, voltage_limit=volts, wheel_rate_limit=rpm * RATE), timing


def _reference(step: float, seconds: float, period: float) -> "StepReference":
    from rwjax.control.response import StepReference

    finite(step=step, seconds=seconds)
    if step == 0.0:
        raise InputError("--step 0: has to be a number other than 0")
    samples = round(seconds / period) if seconds > 0.0 else 0
    if not 10 <= samples <= 1_000_000:
        raise InputError(f"--seconds {seconds:g}: has to hold 10 to 1000000 samples of {period:g} s")
    return StepReference(math.radians(step), seconds)


def sweep(
    rig: RigFile,
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
    """Step responses of RIG's nonlinear closed loop over gains: stick and slip, counts, sampling and limits."""
    import numpy as np

    from rwjax.control.sweep import sweep as run
    from rwjax.report.control import MAPS, csv, draw_maps, of_responses
    from rwjax.rig.read import read_one_axis_rig

    believed = read_one_axis_rig(rig)
    rows, cols = pairs(kp=kp, kd=kd)
    controller, timing = _loop(believed, ki, volts, rpm, period, late, smooth)
    reference = _reference(step, seconds, period)
    with of_file(rig):
        swept = run(believed, rows, cols, controller=controller, step=reference, timing=timing)
    found = swept.response
    maps = {name: plain(np.asarray(getattr(found, field))) for name, (field, _, _) in MAPS.items()}
    answer = {"schema": "rwjax.sweep/1", "kp": rows.tolist(), "kd": cols.tolist(), **maps}
    figure = partial(draw_maps, rows, cols, found, f"responses to {step:g}°, limit {volts:g} V")
    written = write((rig,), output, csv(of_responses(rows, cols, found)), figure, answer, as_json)
    notes = [f"{swept.settled} of {found.settling.size} gain pairs settle within 2 % of the step"]
    if swept.fastest is not None:
        i, j = swept.fastest
        notes.append(f"fastest: kp {rows[i]:g}, kd {cols[j]:g} after {float(found.settling[i, j]):.3g} s")
        notes += [
            f"it lies on the edge of --{name} {text}: widen that range"
            for name, text, values, k in (("kp", kp, rows, i), ("kd", kd, cols, j))
            if len(values) > 1 and values[k] > 0.0 and values[k] in (values.min(), values.max())
        ]
    say(quiet, *notes, *own_delay(believed), *written)


def tune(
    rig: RigFile,
    kp: Annotated[str, typer.Option(metavar="FROM:TO", help="where gains are looked for [V/rad]")] = "0:100",
    kd: Annotated[str, typer.Option(metavar="FROM:TO", help="where gains are looked for [V s/rad]")] = "0:100",
    ki: Annotated[float, typer.Option(help="integral gain to begin with [V/(rad s)]; 0: none")] = 0.0,
    sigma: Sigma = 0.5,
    fit: FitFile = None,
    plants: Plants = 200,
    least: Annotated[float, typer.Option(help="modulus margin that the tuned loop keeps")] = 0.5,
    forward: Annotated[float, typer.Option(help="share of the breakaway friction that is fed forward")] = 0.0,
    dead: Annotated[float, typer.Option(help="error within which nothing is fed forward [°]")] = 0.2,
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
    """Gains for RIG's axis: those of the largest worst-case margin, then tuned through the nonlinear closed loop."""
    import numpy as np

    from rwjax.control.fit_estimate import draw_plants
    from rwjax.control.gain_design import GainRequirement
    from rwjax.control.gain_design import tune as run
    from rwjax.rig.read import read_one_axis_rig

    believed = read_one_axis_rig(rig)
    finite(sigma=sigma, dead=dead)
    if sigma < 0.0:
        raise InputError(f"--sigma {sigma:g}: must not be negative, the loop has to be stable to be tuned")
    if not 0.0 <= forward <= 1.0:
        raise InputError(f"--forward {forward:g}: has to lie between 0 and 1; more makes the loop oscillate")
    if not 0.0 < least < 1.0:
        raise InputError(f"--least {least:g}: has to lie between 0 and 1")
    rows, cols = span("--kp", kp), span("--kd", kd)
    controller, timing = _loop(believed, ki, volts, rpm, period, late, smooth)
    reference = _reference(step, seconds, period)
    believed, spread, said = with_fit(rig, believed, fit)
    with of_file(rig):
        design = run(
            believed,
            GainRequirement(tuple(rows.tolist()), tuple(cols.tolist()), sigma, least),
            controller=controller._replace(deadband=math.radians(dead)),
            friction_share=forward,
            step=reference,
            timing=timing,
            thetas=draw_plants(believed, spread, plants) if spread is not None else None,
        )
    shown = {}
    for name, one in (("robust", design.robust), ("tuned", design.tuned)):
        gains = {key: float(getattr(one.controller, key)) for key in ("kp", "ki", "kd")}
        seen = {key: plain(np.asarray(value)) for key, value in one.response._asdict().items()}
        shown[name] = {**gains, **seen, "modulus": one.robustness.modulus}
    stable = design.tuned.robustness.stable
    if as_json:
        answer = {"schema": "rwjax.tune/1", "plants": design.plants, "stable_with_tuned": stable, **shown}
        print(json.dumps(answer, allow_nan=False))
        return
    for name, found in shown.items():
        settles = "does not settle" if found["settling"] is None else f"settles in {found['settling']:.3g} s"
        print(
            f"{name}: kp {found['kp']:.4g} V/rad, ki {found['ki']:.4g} V/(rad s), kd {found['kd']:.4g} V s/rad; modulus margin "
            f"{found['modulus']:.2f}; {settles}, overshoot {100.0 * found['overshoot']:.2g} %, stays "
            f"{math.degrees(abs(found['error'])):.2g}° off"
        )
    notes = [
        f"robust: kp and kd of the largest worst-case margin over {design.plants} plants, every pole left of -{sigma:g} 1/s{' without ki' if ki else ''} "
        f"(a larger --sigma makes the loop faster); tuned: a step of {step:g}° on the rig{' as fitted' if fit else ' as given'}"
    ]
    if design.plants > 1:
        notes.append(
            f"modulus margin: the worst of these plants; with the tuned gains {100.0 * stable:.4g} % of them are stable"
        )
    if shown["tuned"]["settling"] is None:
        notes.append(
            "not settled: where dry friction holds the axis off its angle, --ki or --forward 0.8 help, else a larger --sigma"
        )
    if design.least_modulus < least:
        notes.append(f"margin kept on the rig alone: {design.least_modulus:.2f}; the robust gains have no {least:g}")
    say(quiet, *said, *notes, *own_delay(believed))


COMMANDS = (sweep, tune)
