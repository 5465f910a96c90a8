"""Eq. 4.2 to 4.6, Figs. 4.1 and 4.2: the on-off slew, ideal and on the plant."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from experiments.thesis.table import row, save
from experiments.thesis.testbed import AMPS, INERTIA, TOP, VOLTS, J, K, yaw_testbed
from rwjax.control.drive_limits import Limits
from rwjax.control.on_off import OnOff
from rwjax.control.slew import slew
from rwjax.errors import InputError
from rwjax.report.control import draw_courses

LIMITS = Limits(VOLTS, AMPS, TOP)


def slews(folder: Path) -> None:
    """Eq. 4.2 to 4.6, Figs. 4.1 and 4.2: the on-off slew over 90 deg, wheel to 4000 rpm."""
    free = slew(yaw_testbed(0.0, friction=False), 0.5 * np.pi, LIMITS)
    ideal = free.ideal
    row(
        "ideal 90 deg: t1 = t3, t2, whole time, at the motor's torque at 4000 rpm and 10 V [s]",
        "",
        f"{ideal.ramp:.3f}, {ideal.hold:.3f}, {ideal.time:.3f}",
    )
    row(
        "… at no friction and no inductance, followed on the plant: misses by [deg]",
        "0",
        f"{np.degrees(free.miss):.1e}",
    )
    row("… least time there: bound (3 A throughout), found [s]", "", f"{_bound():.3f}, {free.time:.3f}")
    real = yaw_testbed()
    try:
        row("90 deg with the friction of eq. 3.14", "", f"{slew(real, 0.5 * np.pi, LIMITS).time:.3f}")
    except InputError as error:
        row(
            "90 deg with the friction of eq. 3.14, wheel from rest to 4000 rpm",
            "90 deg",
            f"not found: {str(error).split(':')[0].strip()}",
        )
    spun = slew(real, 0.5 * np.pi, LIMITS, spin=TOP)
    row("… the ideal law there ends [deg]", "90", f"{90.0 + np.degrees(spun.miss):.1f}")
    row("… least time from -4000 to 4000 rpm [s]", "", f"{spun.time:.3f}")
    half = slew(real, 0.25 * np.pi, LIMITS)
    row(
        "45 deg: ideal time, where the ideal law ends [deg], least time on the plant [s]",
        "",
        f"{half.ideal.time:.3f}, {45.0 + np.degrees(half.miss):.1f}, {half.time:.3f}",
    )
    row("… the wheel is left at [rpm]", "0", f"{abs(float(half.best.wheel[-1])) / TOP * 4000.0:.0f}")
    save(_ideal(ideal), folder, "fig_4_1_4_2")
    save(
        draw_courses(
            {"fastest on the plant": half.best, "ideal law on the plant": half.followed}, "45° on chapter 4's testbed"
        ),
        folder,
        "chapter_4_slew",
    )


def _bound() -> float:
    """Time over 90 deg at 3 A throughout, of which 10 V leave less near 4000 rpm, the wheel held there in between [s]."""
    from rwjax.control.on_off import on_off

    return on_off(INERTIA, J, 0.5 * np.pi, K * AMPS, TOP).time


def _ideal(ideal: OnOff) -> plt.Figure:
    t = np.linspace(0.0, ideal.time, 500)
    figure, axes = plt.subplots(2, 1, figsize=(6, 4.6), sharex=True, layout="constrained")
    axes[0].plot(t, ideal.wheel(t) * 60.0 / (2.0 * np.pi))
    axes[0].set(ylabel="wheel |Ω| [rpm]", title="Figs. 4.1, 4.2: ideal on-off slew over 90°")
    axes[1].plot(t, np.degrees(J / INERTIA * ideal.turned(t)))
    axes[1].set(ylabel="yaw ψ [°]", xlabel="time [s]")
    return figure
