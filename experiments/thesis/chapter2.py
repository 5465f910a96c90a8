"""Chapter 2 of the thesis: sizing the wheel. `python -m experiments.thesis.chapter2 [FOLDER]`."""

from pathlib import Path

import numpy as np

from experiments.thesis.table import folder_of, row, save
from experiments.thesis.testbed import AMPS, INERTIA, TOP, VOLTS, yaw_testbed
from rwjax.control.drive_limits import Limits
from rwjax.control.ring import Ring, slew_time
from rwjax.control.sizing import LIMITS, size_wheels
from rwjax.report.control import draw_sizes

RING = Ring(0.05, 0.04, 0.005)  # m; aluminium
ANGLE, SECONDS = 0.5 * np.pi, 15.0  # the thesis's example
WANTED = np.radians(45.0), 3.0  # rad, s: the map's slew; 90° are beyond every wheel of 10 cm on this axis


def rings() -> tuple[Ring, np.ndarray, np.ndarray]:
    """Rings up to the thesis's limit of 10 cm in diameter, the inner radius 0.8 of the outer one."""
    outer, thickness = np.linspace(0.02, 0.05, 61), np.linspace(1e-3, 15e-3, 57)
    return Ring(outer[:, None], 0.8 * outer[:, None], thickness[None, :]), outer, thickness


def inertia_behind(seconds: float, inertia: float) -> float:
    """Axis inertia [kg m²] that a wheel of this inertia at 4000 rpm turns over 90° in some seconds (eq. 2.3)."""
    return seconds * inertia * TOP / (2.0 * ANGLE)


def sizing(folder: Path) -> None:
    """Eq. 2.1 to 2.7: the ring wheel, 90° in 15 s, and what friction makes of it."""
    thin, right = float(RING.thin_inertia), float(RING.inertia)
    row("mass of the ring, 5 cm, 4 cm, 0.5 cm, aluminium [kg]", "", f"{float(RING.mass):.4f}")
    row("its inertia, eq. 2.7 (m R^2) and m (R^2 + r^2)/2 [kg m2]", "", f"{thin:.3g}, {right:.3g} (18 % less)")
    row("momentum at 4000 rpm, either way [N m s]", "", f"{thin * TOP:.4f}, {right * TOP:.4f}")
    behind = inertia_behind(SECONDS, thin)
    row(
        "axis inertia behind 90 deg in 15 s (not printed) [kg m2]",
        "",
        f"{behind:.3f}; with the right wheel {inertia_behind(SECONDS, right):.3f}",
    )
    row("90 deg with that axis and the right wheel [s]", "15", f"{slew_time(behind, ANGLE, right * TOP):.1f}")
    row(
        "90 deg with chapter 4's axis (0.0495 kg m2), either way [s]",
        "",
        f"{slew_time(INERTIA, ANGLE, thin * TOP):.2f}, {slew_time(INERTIA, ANGLE, right * TOP):.2f}",
    )
    limits = Limits(VOLTS, AMPS, TOP)
    found = size_wheels(yaw_testbed(), np.array([thin, right]), ANGLE, SECONDS, limits)
    row(
        "the same with the friction of eq. 3.14 and the motor's limits [s]",
        "",
        f"{found.time[0]}: {LIMITS[int(found.limit[0])]} stops the axis first",
    )
    angle, seconds = WANTED
    ring, outer, thickness = rings()
    over = size_wheels(yaw_testbed(), np.asarray(ring.inertia), angle, seconds, limits)
    does = over.time <= seconds
    i, j = np.unravel_index(np.argmin(np.where(does, ring.mass, np.inf)), does.shape)
    row(
        "lightest ring for 45 deg in 3 s within 10 cm: radius, thickness [mm], mass [g]",
        "",
        f"{1e3 * outer[i]:.1f}, {1e3 * thickness[j]:.2f}, {1e3 * float(np.asarray(ring.mass)[i, j]):.0f}; {LIMITS[int(over.limit[i, j])]} binds",
    )
    row(
        "momentum and torque that it needs [N m s, N m]",
        "",
        f"{over.needs_momentum:.3f}, {over.needs_torque:.3f} (motor: {over.torque:.3f})",
    )
    save(
        draw_sizes(ring, over, seconds, "chapter 2 again: 45° within 3 s, aluminium rings, 10 V, 3 A, 4000 rpm"),
        folder,
        "chapter_2_sizing",
    )


def main(folder: Path) -> None:
    """Prints the table and draws the map."""
    print(sizing.__doc__)
    sizing(folder)


if __name__ == "__main__":
    main(folder_of())
