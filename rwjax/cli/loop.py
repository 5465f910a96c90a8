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
    clockwork_of,
    own_delay,
    pairs,
    plain,
    say,
    with_fit,
    write,
)
from rwjax.cli.options import RATE, Json, Quiet, RigFile, finite, of_file, positive, span
from rwjax.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from rwjax.control.closed_loop import Controller, LoopTiming
    from rwjax.rig.model import Rig

Period = Annotated[float, typer.Option(help="sample time of the controller [s]")]
Ki = Annotated[float, typer.Option(help="integral gain [V/(rad s)]")]
Step = Annotated[float, typer.Option(help="step of the reference [°]")]
Seconds = Annotated[float, typer.Option(help="length of a response [s]")]


def _loop(
    rig: "Rig", ki: float, volts: float, rpm: float, period: float, late: float, smooth: float
) -> "tuple[Controller, LoopTiming]":
    """What a controller's options say, its gains but the integral one left at 0."""
    from rwjax.control.closed_loop import Controller

    finite(ki=ki, volts=volts)
    positive(volts=volts, rpm=rpm)
    if ki < 0.0:
        raise InputError("--ki: must not be negative")
    clockwork = clockwork_of(rig, period, late, smooth)
    return Controller(0.0, ki=ki, smooth=smooth, limit=volts, spin=rpm * RATE), clockwork


def _reference(step: float, seconds: float, period: float) -> "np.ndarray":
    import numpy as np

    finite(step=step, seconds=seconds)
    if step == 0.0:
        raise InputError("--step 0: has to be a number other than 0")
    samples = round(seconds / period) if seconds > 0.0 else 0
    if not 10 <= samples <= 1_000_000:
        raise InputError(f"--seconds {seconds:g}: has to hold 10 to 1000000 samples of {period:g} s")
    return np.full(samples, math.radians(step))


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

    from rwjax.control.response import Response
    from rwjax.control.sweep import sweep as run
    from rwjax.report.control import MAPS, csv, draw_maps, of_responses
    from rwjax.rig.read import read_one_axis_rig

    believed = read_one_axis_rig(rig)
    rows, cols = pairs(kp=kp, kd=kd)
    controller, clockwork = _loop(believed, ki, volts, rpm, period, late, smooth)
    reference = _reference(step, seconds, period)
    with of_file(rig):
        controllers = [controller._replace(kp=p, kd=d) for p in rows for d in cols]
        lanes = run(believed, controllers, reference[None], clockwork)
    found = Response(*(x.reshape(len(rows), len(cols)) for x in lanes))
    maps = {name: plain(np.asarray(getattr(found, field))) for name, (field, _, _) in MAPS.items()}
    answer = {"schema": "rwjax.sweep/1", "kp": rows.tolist(), "kd": cols.tolist(), **maps}
    figure = partial(draw_maps, rows, cols, found, f"responses to {step:g}°, limit {volts:g} V")
    written = write((rig,), output, csv(of_responses(rows, cols, found)), figure, answer, as_json)
    settles = np.isfinite(found.settling)
    notes = [f"{int(settles.sum())} of {settles.size} gain pairs settle within 2 % of the step"]
    if settles.any():
        i, j = np.unravel_index(np.argmin(found.settling), settles.shape)
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

    from rwjax.control.closed_loop import breakaway, run_rig
    from rwjax.control.response import step_response
    from rwjax.control.robust import draw, robust_gains
    from rwjax.control.tuning import judged
    from rwjax.control.tuning import tune as run
    from rwjax.plant.from_rig import structure_of, theta_of
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
    controller, clockwork = _loop(believed, ki, volts, rpm, period, late, smooth)
    reference = _reference(step, seconds, period)
    believed, spread, said = with_fit(rig, believed, fit)
    with of_file(rig):
        alone = theta_of(believed, structure_of(believed))[None]
        thetas = draw(believed, spread, plants) if spread is not None else alone
        robust = robust_gains(believed, thetas, rows, cols, sigma, clockwork, smooth)
        controller = controller._replace(
            kp=robust.kp, kd=robust.kd, forward=forward * breakaway(believed), dead=math.radians(dead)
        )
        start = judged(believed, thetas, clockwork, controller)
        if start.stable < 1.0:
            less = f"--ki {ki:g}: with it" if ki > 0.0 else f"--sigma {sigma:g}:"
            right = "lower --ki" if ki > 0.0 else "ask for a larger --sigma"
            raise InputError(
                f"{less} the loop is not stable at the most robust gains, kp {robust.kp:.3g} and kd {robust.kd:.3g}; {right}"
            )
        tuned = run(believed, controller, reference, clockwork, least)
        end = judged(believed, thetas, clockwork, tuned.controller)
        shown = {}
        for name, law in (("robust", controller), ("tuned", tuned.controller)):
            seen = step_response(run_rig(believed, law, reference, clockwork), reference[-1], period, volts)
            gains = {key: float(getattr(law, key)) for key in ("kp", "ki", "kd")}
            shown[name] = gains | {key: plain(np.asarray(value)) for key, value in seen._asdict().items()}
    shown["robust"]["modulus"], shown["tuned"]["modulus"] = start.modulus, end.modulus
    if as_json:
        answer = {"schema": "rwjax.tune/1", "plants": len(thetas), "stable_with_tuned": end.stable, **shown}
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
        f"robust: kp and kd of the largest worst-case margin over {len(thetas)} plants, every pole left of -{sigma:g} 1/s{' without ki' if ki else ''} "
        f"(a larger --sigma makes the loop faster); tuned: a step of {step:g}° on the rig{' as fitted' if fit else ' as given'}"
    ]
    if len(thetas) > 1:
        notes.append(
            f"modulus margin: the worst of these plants; with the tuned gains {100.0 * end.stable:.4g} % of them are stable"
        )
    if shown["tuned"]["settling"] is None:
        notes.append(
            "not settled: where dry friction holds the axis off its angle, --ki or --forward 0.8 help, else a larger --sigma"
        )
    if tuned.least < least:
        notes.append(f"margin kept on the rig alone: {tuned.least:.2f}; the robust gains have no {least:g}")
    say(quiet, *said, *notes, *own_delay(believed))


COMMANDS = (sweep, tune)
