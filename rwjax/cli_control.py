"""The commands that design and analyse the control of a rig's axis."""

import json
import math
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli_options import RATE, Json, Quiet, RigFile, axis, finite, keep_input, of_file, positive, span
from rwjax.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure

    from rwjax.control.closed_loop import Clockwork, Controller
    from rwjax.control.open_loop import Limits
    from rwjax.control.robust import Spread
    from rwjax.rig import Rig

Kp = Annotated[str, typer.Option(metavar="FROM:TO:COUNT", help="proportional gains [V/rad]")]
Kd = Annotated[str, typer.Option(metavar="FROM:TO:COUNT", help="derivative gains [V s/rad]")]
Sigma = Annotated[float, typer.Option(help="every pole left of minus this [1/s]")]
Volts = Annotated[float, typer.Option(help="largest command [V]")]
Amps = Annotated[float, typer.Option(help="largest current [A]")]
Rpm = Annotated[float, typer.Option(help="largest rate of the wheel [1/min]")]
Degrees = Annotated[float, typer.Option("--angle", help="angle to turn [°]")]
Output = Annotated[Path | None, typer.Option("-o", metavar="CSV", help="stdout without it; a figure beside it")]
FitFile = Annotated[
    Path | None,
    typer.Option(
        "--fit", metavar="FIT.json", help="what `rwjax fit RIG LOG… --json` printed for this rig; its values count"
    ),
]
Plants = Annotated[int, typer.Option(min=1, max=100_000, help="plants drawn from the fit")]
PAIRS = 1_000_000
STEPS, LONGEST = 4, 2.5e-3  # of the plant in a period of the controller: at least so many, none longer [s]


def _pairs(example: str = "0:100:101", **options: str) -> "tuple[np.ndarray, np.ndarray]":
    """The values of two options, at most `PAIRS` of both."""
    first, second = (axis(f"--{name}", text, example) for name, text in options.items())
    if len(first) * len(second) > PAIRS:
        given = " ".join(f"--{name} {text}" for name, text in options.items())
        raise InputError(f"{given}: {len(first) * len(second)} pairs are more than {PAIRS}; take fewer")
    return first, second


def _limits(volts: float, amps: float, rpm: float) -> "Limits":
    from rwjax.control.open_loop import Limits

    finite(volts=volts)
    positive(volts=volts, amps=amps, rpm=rpm)
    return Limits(volts, amps, rpm * RATE)


def _write(
    inputs: tuple[Path, ...],
    output: Path | None,
    text: str,
    figure: "Callable[[], Figure]",
    answer: dict,
    as_json: bool,
) -> None:
    """The table to a file, with the figure beside it, or to stdout; the answer there if wanted. A device gets the table alone."""
    from rwjax.errors import write_text
    from rwjax.report.control import write_png

    if output is not None:
        if output.suffix.lower() == ".png":
            raise InputError(
                f"-o {output}: is the table's path, the figure is written beside it; take one that ends with .csv"
            )
        keep_input(output, *inputs)
        write_text(output, text, InputError)
        if output.is_file():
            keep_input(output.with_suffix(".png"), *inputs)
            write_png(figure(), output.with_suffix(".png"))
    if as_json:
        print(json.dumps(answer, allow_nan=False))
    elif output is None:
        print(text, end="")


def _plain(values: "np.ndarray") -> list | float | None:
    """Nested lists, or one number; None for what is not finite."""
    import numpy as np

    plain = np.array(values, object)
    plain[~np.isfinite(values)] = None
    return plain.tolist()


def _say(quiet: bool, *lines: str) -> None:
    if not quiet:
        print("\n".join(lines), file=sys.stderr)


def _without(rig: "Rig", effect: str) -> "Rig":
    from rwjax.errors import nearest

    if effect not in rig.effects:
        held = f"nearest `{nearest(effect, rig.effects)}`" if rig.effects else "it holds none"
        raise InputError(f"--without {effect}: the rig file holds no such effect; {held}")
    return replace(rig, effects={name: numbers for name, numbers in rig.effects.items() if name != effect})


def _fitted(path: Path, rig: "Rig", fit: Path | None) -> "tuple[Rig, Spread | None, list[str]]":
    """The rig with a fit's estimates, what the fit says of them, and a line where the rig file says otherwise."""
    from rwjax.control.robust import fitted, read_spread

    if fit is None:
        return rig, None, []
    spread = read_spread(fit, rig)
    with of_file(path):
        found = fitted(rig, spread)
    pairs = [(name, f"{found.values[name]:.6g}", f"{rig.values[name]:.6g}") for name in spread.names]
    other = [f"{name} {new} (not {old})" for name, new, old in pairs if new != old]
    return found, spread, [f"taken from {fit} where {path} says otherwise: {', '.join(other)}"] if other else []


def region(
    rig: RigFile,
    kp: Kp = "0:100:101",
    kd: Kd = "0:100:101",
    sigma: Sigma = 0.5,
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
    """PD gains of RIG's axis that put every pole of the closed loop left of -sigma."""
    import numpy as np

    from rwjax.control.linear import linearised, taken_as, transfer, without_lateness
    from rwjax.control.region import pd_region, share_of_plants
    from rwjax.control.robust import draw
    from rwjax.report.control import csv
    from rwjax.report.region import columns, draw_region
    from rwjax.rig import read_one_axis_rig

    finite(sigma=sigma, angle=angle)
    believed, held = read_one_axis_rig(rig), math.radians(angle)
    gains = _pairs(kp=kp, kd=kd)
    beside: dict[str, np.ndarray] = {}
    believed, spread, said = _fitted(rig, believed, fit)
    with of_file(rig):
        found = pd_region(believed, *gains, sigma, held)
        if without is not None:
            rest = pd_region(_without(believed, without), *gains, sigma, held)
            beside[f"without {without}"] = rest.stable.astype(float)
        if spread is not None:
            thetas = draw(believed, spread, plants)
            beside["share of plants"] = share_of_plants(transfer(linearised(believed, held, thetas)), *gains, sigma)
    answer = {
        "schema": "rwjax.region/1",
        "kp": found.kp.tolist(),
        "kd": found.kd.tolist(),
        "sigma": sigma,
        "stable": found.stable.astype(int).tolist(),
        "share": found.share,
        "left_out": list(found.plant.hidden),
        **{name.replace(" ", "_"): value.tolist() for name, value in beside.items()},
    }
    inputs = (rig,) if fit is None else (rig, fit)
    _write(inputs, output, csv(columns(found, beside)), lambda: draw_region(found, beside), answer, as_json)
    notes = [f"{int(found.stable.sum())} of {found.stable.size} gain pairs put every pole left of -{sigma:g} 1/s"]
    for name, value in beside.items():
        every, differ = int(np.sum(value == 1.0)), int(np.sum((value == 1.0) != found.stable))
        what = f"{every} do so for all {plants} plants drawn" if name == "share of plants" else f"{name}: {every}"
        notes.append(f"{what}; {differ} pairs are judged otherwise")
    notes += ["left out: the conserved momentum's pole at 0, which no gain moves"] if found.plant.hidden else []
    late = without_lateness(believed)
    notes += [f"left out: {', '.join(late)}, which no transfer function holds"] if late else []
    _say(quiet, *said, *notes, *taken_as(believed))


def _loop(
    rig: "Rig", ki: float, volts: float, rpm: float, period: float, late: float, smooth: float
) -> "tuple[Controller, Clockwork]":
    """What a controller's options say, its gains but the integral one left at 0."""
    from rwjax.control.closed_loop import Clockwork, Controller

    finite(ki=ki, volts=volts, period=period, late=late, smooth=smooth)
    positive(volts=volts, rpm=rpm, period=period)
    if not 0.0 <= late <= period:
        raise InputError(f"--late {late:g}: has to lie between 0 and the period of {period:g} s")
    if smooth < 0.0 or ki < 0.0:
        raise InputError(f"--{'smooth' if smooth < 0.0 else 'ki'}: must not be negative")
    steps = max(STEPS, math.ceil(period / LONGEST - 1e-9))
    clockwork = Clockwork(period, steps, steps * late / period, int(rig.counts_per_rev.get("axis", 0)))
    return Controller(0.0, ki=ki, smooth=smooth, limit=volts, spin=rpm * RATE), clockwork


Period = Annotated[float, typer.Option(help="sample time of the controller [s]")]
Late = Annotated[float, typer.Option(help="time from a reading to its command [s]")]
Smooth = Annotated[float, typer.Option(help="time constant of the derivative's filter [s]")]
Ki = Annotated[float, typer.Option(help="integral gain [V/(rad s)]")]
Step = Annotated[float, typer.Option(help="step of the reference [°]")]
Seconds = Annotated[float, typer.Option(help="length of a response [s]")]


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
    from rwjax.rig import read_one_axis_rig

    believed = read_one_axis_rig(rig)
    rows, cols = _pairs(kp=kp, kd=kd)
    controller, clockwork = _loop(believed, ki, volts, rpm, period, late, smooth)
    reference = _reference(step, seconds, period)
    with of_file(rig):
        controllers = [controller._replace(kp=p, kd=d) for p in rows for d in cols]
        lanes = run(believed, controllers, reference[None], clockwork)
    found = Response(*(x.reshape(len(rows), len(cols)) for x in lanes))
    maps = {name: _plain(np.asarray(getattr(found, field))) for name, (field, _, _) in MAPS.items()}
    answer = {"schema": "rwjax.sweep/1", "kp": rows.tolist(), "kd": cols.tolist(), **maps}
    figure = partial(draw_maps, rows, cols, found, f"responses to {step:g}°, limit {volts:g} V")
    _write((rig,), output, csv(of_responses(rows, cols, found)), figure, answer, as_json)
    settles = np.isfinite(found.settling)
    notes = [f"{int(settles.sum())} of {settles.size} gain pairs settle within 2 % of the step"]
    if settles.any():
        i, j = np.unravel_index(np.argmin(found.settling), settles.shape)
        notes.append(f"fastest: kp {rows[i]:g}, kd {cols[j]:g} after {float(found.settling[i, j]):.3g} s")
    _say(quiet, *notes)


def slew(
    rig: RigFile,
    angle: Degrees,
    volts: Volts = 10.0,
    amps: Amps = math.inf,
    rpm: Rpm = math.inf,
    spin: Annotated[float, typer.Option(help="rate of the wheel beforehand [1/min]")] = 0.0,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """The fastest turn of RIG's axis from rest to rest, and what the ideal on-off law makes of it."""
    import numpy as np

    from rwjax.control.slew import slew as run
    from rwjax.report.control import csv, draw_courses, of_course
    from rwjax.rig import read_one_axis_rig

    finite(angle=angle, spin=spin)
    believed, limits = read_one_axis_rig(rig), _limits(volts, amps, rpm)
    with of_file(rig):
        found = run(believed, math.radians(angle), limits, spin * RATE)
    ideal, miss = found.ideal, math.degrees(found.miss)
    answer = {
        "schema": "rwjax.slew/1",
        "ideal": {"ramp_s": ideal.ramp, "hold_s": ideal.hold, "time_s": ideal.time, "wheel_rad_s": ideal.top},
        "miss_deg": miss,
        "least_time_s": found.time,
        **{name: np.asarray(value).tolist() for name, value in of_course(found.best).items()},
    }
    figure = partial(
        draw_courses, {"fastest on the plant": found.best, "ideal on-off law": found.followed}, f"{angle:g}° slew"
    )
    _write((rig,), output, csv(of_course(found.best)), figure, answer, as_json)
    _say(
        quiet,
        f"ideal on-off law: {ideal.time:.3f} s ({ideal.ramp:.3f} up, {ideal.hold:.3f} held, {ideal.ramp:.3f} down), wheel to "
        f"{ideal.top / RATE:.0f} 1/min; on this rig it ends {abs(miss):.3g}° {'short' if miss * angle < 0.0 else 'beyond'}",
        f"fastest on this rig: {found.time:.3f} s; the wheel goes on at {float(found.best.wheel[-1]) / RATE:.0f} 1/min",
    )


def dump(
    rig: RigFile,
    spin: Annotated[float, typer.Option(help="rate of the wheel [1/min]")],
    volts: Volts = 10.0,
    amps: Amps = math.inf,
    margin: Annotated[float, typer.Option(help="share of the breakaway torque to use")] = 0.9,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """The fastest stop of RIG's wheel in which static friction holds the axis."""
    import numpy as np

    from rwjax.control.dumping import dump as run
    from rwjax.report.control import csv, draw_courses, of_course
    from rwjax.rig import read_one_axis_rig

    finite(spin=spin, margin=margin)
    believed, limits = read_one_axis_rig(rig), _limits(volts, amps, math.inf)
    with of_file(rig):
        found = run(believed, spin * RATE, limits, margin)
    moved = math.degrees(float(np.max(np.abs(np.asarray(found.best.angle)))))
    answer = {
        "schema": "rwjax.dump/1",
        "bound_s": found.bound,
        "least_time_s": found.time,
        "moved_deg": moved,
        **{name: np.asarray(value).tolist() for name, value in of_course(found.best).items()},
    }
    figure = partial(draw_courses, {f"from {spin:g} 1/min": found.best}, "the wheel stops, the axis does not move")
    _write((rig,), output, csv(of_course(found.best)), figure, answer, as_json)
    _say(
        quiet,
        f"{found.time:.3f} s; "
        + (
            f"with a share of {margin:g} of the breakaway torque no command does it in less than {found.bound:.3f} s; "
            if found.bound
            else ""
        )
        + f"the axis moves by {moved:.2g}°",
    )


def size(
    rig: RigFile,
    angle: Degrees,
    seconds: Annotated[float, typer.Option(help="time in which the turn is wanted [s]")],
    radius: Annotated[str, typer.Option(metavar="FROM:TO:COUNT", help="outer radius of the ring [mm]")] = "20:50:61",
    thickness: Annotated[str, typer.Option(metavar="FROM:TO:COUNT", help="thickness of the ring [mm]")] = "1:10:61",
    inner: Annotated[float, typer.Option(help="inner radius over the outer one")] = 0.8,
    density: Annotated[float, typer.Option(help="of the ring [kg/m³]; aluminium by default")] = 2700.0,
    volts: Volts = 10.0,
    amps: Amps = math.inf,
    rpm: Rpm = 4000.0,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Ring wheels for RIG's motor and axis: time of a wanted turn over radius and thickness, and which limit binds."""
    import numpy as np

    from rwjax.control.sizing import LIMITS, Ring
    from rwjax.control.sizing import size as run
    from rwjax.report.control import csv, draw_sizes, of_sizes
    from rwjax.rig import read_one_axis_rig

    believed, limits = read_one_axis_rig(rig), _limits(volts, amps, rpm)
    finite(angle=angle, seconds=seconds, density=density)
    positive(density=density, seconds=seconds)
    if not 0.0 <= inner < 1.0:
        raise InputError(f"--inner {inner:g}: has to lie between 0 (a disc) and below 1")
    outer, thick = (1e-3 * values for values in _pairs("20:50:61", radius=radius, thickness=thickness))
    for option, values in (("--radius", outer), ("--thickness", thick)):
        if values.min() <= 0.0:
            raise InputError(f"{option}: has to be positive [mm]")
    ring = Ring(outer[:, None], inner * outer[:, None], thick[None, :], density)
    mass, inertia = np.asarray(ring.mass), np.asarray(ring.inertia)
    with of_file(rig):
        found = run(believed, inertia, abs(math.radians(angle)), seconds, limits)
    columns = of_sizes(ring, found)
    answer = {
        "schema": "rwjax.size/1",
        "needs": {"momentum_N_m_s": found.needs_momentum, "torque_N_m": found.needs_torque},
        "torque_N_m": found.torque,
        **{name: v.tolist() if name == "limit" else _plain(v) for name, v in columns.items()},
    }
    figure = partial(draw_sizes, ring, found, seconds, f"{angle:g}° within {seconds:g} s: rings of {density:g} kg/m³")
    _write((rig,), output, csv(columns), figure, answer, as_json)
    notes = [
        f"needed without a hold: {found.needs_momentum:.3g} N m s and {found.needs_torque:.3g} N m; the motor has "
        f"{found.torque:.3g} N m at the wheel's top rate"
    ]
    fits = found.time <= seconds
    if fits.any():
        i, j = np.unravel_index(np.argmin(np.where(fits, mass, np.inf)), fits.shape)
        notes.append(
            f"lightest that does it: {1e3 * outer[i]:.3g} mm by {1e3 * thick[j]:.3g} mm, {1e3 * mass[i, j]:.3g} g, "
            f"{inertia[i, j]:.3g} kg m², {found.time[i, j]:.3g} s; {LIMITS[int(found.limit[i, j])]} binds"
        )
    else:
        notes.append("none of these rings does it")
    _say(quiet, *notes)


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

    from rwjax.build import structure_of, theta_of
    from rwjax.control.closed_loop import breakaway, run_rig
    from rwjax.control.response import step_response
    from rwjax.control.robust import draw, robust_gains
    from rwjax.control.tuning import judged
    from rwjax.control.tuning import tune as run
    from rwjax.rig import read_one_axis_rig

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
    believed, spread, said = _fitted(rig, believed, fit)
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
            shown[name] = gains | {key: _plain(np.asarray(value)) for key, value in seen._asdict().items()}
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
    _say(quiet, *said, *notes)


COMMANDS = (region, sweep, tune, slew, dump, size)
