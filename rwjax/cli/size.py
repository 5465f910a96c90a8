"""The command `size`: ring wheels for a rig's motor and axis."""

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.control import Output, Rpm, Volts, check_table, on_edge, pairs, remark, write_results
from rwjax.cli.manoeuvre import Amps, Degrees, limits_of, of_rig_or_option
from rwjax.cli.options import Json, Quiet, RigFile, finite, positive
from rwjax.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from rwjax.control.ring import Ring
    from rwjax.control.sizing import WheelBudget

Seconds = Annotated[float, typer.Option(help="time in which the turn is wanted [s]")]
Radius = Annotated[str, typer.Option(metavar="FROM:TO:COUNT", help="outer radius of the ring [mm]")]
Thickness = Annotated[str, typer.Option(metavar="FROM:TO:COUNT", help="thickness of the ring [mm]")]
Inner = Annotated[float, typer.Option(help="inner radius over the outer one")]
Density = Annotated[float, typer.Option(help="of the ring [kg/m³]; aluminium by default")]


def size(
    rig_file: RigFile,
    angle: Degrees,
    seconds: Seconds,
    radius: Radius = "20:50:61",
    thickness: Thickness = "1:10:61",
    inner: Inner = 0.8,
    density: Density = 2700.0,
    volts: Volts = 10.0,
    amps: Amps = math.inf,
    rpm: Rpm = 4000.0,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Ring wheels for RIG's motor and axis: time of a wanted turn over radius and thickness, and which limit binds.

    Example: `rwjax size yaw.toml --angle 45 --seconds 3`
    """
    import numpy as np

    from rwjax.control.ring import Ring
    from rwjax.control.sizing import size_wheels as run
    from rwjax.report.control import draw_sizes, size_columns
    from rwjax.report.table import csv
    from rwjax.rig.read import read_one_axis_rig

    check_table(output, rig_file)
    rig, limits = read_one_axis_rig(rig_file), limits_of(volts, amps, rpm)
    finite(angle=angle, seconds=seconds, density=density)
    positive(density=density, seconds=seconds)
    outer, thick = _sizes(radius, thickness, inner)
    ring = Ring(outer[:, None], inner * outer[:, None], thick[None, :], density)
    with of_rig_or_option(rig_file):
        found = run(rig, np.asarray(ring.inertia), abs(math.radians(angle)), seconds, limits)
    columns = size_columns(ring, found)
    answer = {
        "schema": "rwjax.size/1",
        "needs": {"momentum_N_m_s": found.needs_momentum, "torque_N_m": found.needs_torque},
        "torque_N_m": found.torque,
        "delay_s": found.delay,
        **{name: v.tolist() for name, v in columns.items()},
        "time_s": [
            None if time == math.inf else time for time in columns["time_s"].tolist()
        ],  # the angle is not reached
    }
    figure = partial(draw_sizes, ring, found, seconds, f"{angle:g}° within {seconds:g} s: rings of {density:g} kg/m³")
    written = write_results(output, csv(columns), figure, answer, as_json)
    delay = [f"the drive's delay of {found.delay:g} s is in these times"] if found.delay else []
    remark(quiet, *_notes(ring, found, seconds, {"radius": radius, "thickness": thickness}), *written, *delay)


def _sizes(radius: str, thickness: str, inner: float) -> "tuple[np.ndarray, np.ndarray]":
    """Outer radii and thicknesses [m]. Raises `InputError` for what no ring has."""
    if not 0.0 <= inner < 1.0:
        raise InputError(f"--inner {inner:g}: has to lie between 0 (a disc) and below 1")
    outer, thick = (1e-3 * values for values in pairs("20:50:61", radius=radius, thickness=thickness))
    for option, values in (("--radius", outer), ("--thickness", thick)):
        if values.min() <= 0.0:
            raise InputError(f"{option}: has to be positive [mm]")
    return outer, thick


def _notes(ring: "Ring", found: "WheelBudget", seconds: float, given: dict[str, str]) -> list[str]:
    """What the turn needs, the lightest wheel that does it, and whether it lies on the edge of a range that the user gave."""
    import numpy as np

    from rwjax.control.sizing import LIMITS

    outer, thick = np.ravel(ring.outer), np.ravel(ring.thickness)
    needed = (
        f"to turn in {seconds:g} s, driven first and braked right after, takes a torque of {found.needs_torque:.3g} N m and a momentum of "
        f"{found.needs_momentum:.3g} N m s; the motor gives {found.torque:.3g} N m at the wheel's top rate"
    )
    fits = found.time <= seconds
    if not fits.any():
        return [needed, f"none of these rings, up to {1e3 * outer.max():g} mm by {1e3 * thick.max():g} mm, does it"]
    mass, inertia = np.asarray(ring.mass), np.asarray(ring.inertia)
    i, j = np.unravel_index(np.argmin(np.where(fits, mass, np.inf)), fits.shape)
    return [
        needed,
        f"lightest that does it: {1e3 * outer[i]:.3g} mm by {1e3 * thick[j]:.3g} mm, {1e3 * mass[i, j]:.3g} g, "
        f"{inertia[i, j]:.3g} kg m², {found.time[i, j]:.3g} s; {LIMITS[int(found.limit[i, j])]} binds",
        *on_edge(given, (outer, thick), (int(i), int(j))),
    ]
