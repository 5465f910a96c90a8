"""The commands for manoeuvres without feedback, and for the wheel that they need: `slew`, `dump` and `size`."""

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.control import Output, Rpm, Volts, pairs, plain, say, write
from rwjax.cli.options import RATE, Json, Quiet, RigFile, finite, of_file, positive
from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.control.drive_limits import Limits

Amps = Annotated[float, typer.Option(help="largest current [A]")]
Degrees = Annotated[float, typer.Option("--angle", help="angle to turn [°]")]


def _limits(volts: float, amps: float, rpm: float) -> "Limits":
    from rwjax.control.drive_limits import Limits

    finite(volts=volts)
    positive(volts=volts, amps=amps, rpm=rpm)
    return Limits(volts, amps, rpm * RATE)


def _delayed(delay: float) -> list[str]:
    """A line on a delay of the drive, if there is one."""
    return (
        [f"the drive's delay of {delay:g} s is in this time: what the table shows happens so much later"]
        if delay
        else []
    )


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
    from rwjax.rig.read import read_one_axis_rig

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
        "delay_s": found.delay,
        **{name: np.asarray(value).tolist() for name, value in of_course(found.best).items()},
    }
    figure = partial(
        draw_courses, {"fastest on the plant": found.best, "ideal on-off law": found.followed}, f"{angle:g}° slew"
    )
    written = write((rig,), output, csv(of_course(found.best)), figure, answer, as_json)
    say(
        quiet,
        f"ideal on-off law, no friction, with the torque that the motor has left at {found.top / RATE:.0f} 1/min: {ideal.time:.3f} s "
        f"({ideal.ramp:.3f} up, {ideal.hold:.3f} held, {ideal.ramp:.3f} down), wheel to {ideal.top / RATE:.0f} 1/min; on this rig it ends {abs(miss):.3g}° {'short' if miss * angle < 0.0 else 'beyond'}",
        f"fastest on this rig: {found.time:.3f} s; the wheel goes on at {float(found.best.wheel[-1]) / RATE:.0f} 1/min",
        *_delayed(found.delay),
        *written,
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

    from rwjax.control.momentum_dump import dump as run
    from rwjax.report.control import csv, draw_courses, of_course
    from rwjax.rig.read import read_one_axis_rig

    finite(spin=spin, margin=margin)
    believed, limits = read_one_axis_rig(rig), _limits(volts, amps, math.inf)
    with of_file(rig):
        found = run(believed, spin * RATE, limits, margin)
    moved = math.degrees(float(np.max(np.abs(np.asarray(found.best.angle)))))
    answer = {
        "schema": "rwjax.dump/1",
        "bound_s": found.bound,
        "least_time_s": found.time,
        "delay_s": found.delay,
        "moved_deg": moved,
        **{name: np.asarray(value).tolist() for name, value in of_course(found.best).items()},
    }
    figure = partial(draw_courses, {f"from {spin:g} 1/min": found.best}, "the wheel stops, the axis does not move")
    written = write((rig,), output, csv(of_course(found.best)), figure, answer, as_json)
    say(
        quiet,
        f"{found.time:.3f} s; "
        + (
            f"with a share of {margin:g} of the breakaway torque no command does it in less than {found.bound:.3f} s; "
            if found.bound
            else ""
        )
        + f"the axis moves by {moved:.2g}°",
        *_delayed(found.delay),
        *written,
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

    from rwjax.control.ring import Ring
    from rwjax.control.sizing import LIMITS
    from rwjax.control.sizing import size_wheels as run
    from rwjax.report.control import csv, draw_sizes, of_sizes
    from rwjax.rig.read import read_one_axis_rig

    believed, limits = read_one_axis_rig(rig), _limits(volts, amps, rpm)
    finite(angle=angle, seconds=seconds, density=density)
    positive(density=density, seconds=seconds)
    if not 0.0 <= inner < 1.0:
        raise InputError(f"--inner {inner:g}: has to lie between 0 (a disc) and below 1")
    outer, thick = (1e-3 * values for values in pairs("20:50:61", radius=radius, thickness=thickness))
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
        "delay_s": found.delay,
        **{name: v.tolist() if name == "limit" else plain(v) for name, v in columns.items()},
    }
    figure = partial(draw_sizes, ring, found, seconds, f"{angle:g}° within {seconds:g} s: rings of {density:g} kg/m³")
    written = write((rig,), output, csv(columns), figure, answer, as_json)
    notes = [
        f"needed if the wheel turns round halfway: {found.needs_momentum:.3g} N m s and {found.needs_torque:.3g} N m; the motor has "
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
        notes.append(f"none of these rings, up to {1e3 * outer.max():g} mm by {1e3 * thick.max():g} mm, does it")
    say(
        quiet, *notes, *written, *([f"the drive's delay of {found.delay:g} s is in these times"] if found.delay else [])
    )


COMMANDS = (slew, dump, size)
