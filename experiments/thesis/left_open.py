"""What chapter 4 leaves open: friction fed forward, an integral, tuned gains, and the wheel's momentum put into the bearing."""

from pathlib import Path

import numpy as np

from experiments.thesis.square_waves import CLOCK, STIFF, controller, wave
from experiments.thesis.table import row, save
from experiments.thesis.testbed import AMPS, TOP, VOLTS, yaw_testbed
from rwjax.control.breakaway import breakaway
from rwjax.control.controller import Controller
from rwjax.control.drive_limits import Limits
from rwjax.control.momentum_dump import Dump, dump
from rwjax.control.open_loop import Trajectory, open_loop, steady_state
from rwjax.control.tuning import tune_from
from rwjax.report.control import draw_courses

STEP = np.full(1000, np.radians(20.0))
DEAD = np.radians(0.2)


def laws() -> dict[str, Controller]:
    """The thesis's stiff gains, with what it left open added, and tuned by gradient from there."""
    forward = 0.8 * breakaway(yaw_testbed())
    plain = controller(*STIFF)
    fed = plain._replace(feedforward=forward, deadband=DEAD)
    integral = plain._replace(ki=20.0)
    return {
        "PD (100, 10)": plain,
        "… friction fed forward": fed,
        "… integral, held while clipped": integral,
        "PD tuned": tune_from(yaw_testbed(), plain, STEP, CLOCK).controller,
        "PID tuned": tune_from(yaw_testbed(), integral, STEP, CLOCK).controller,
    }


def rushed(found: Dump, share: float) -> Trajectory:
    """The commands of a dump in a share of its time."""
    structure, theta, start = steady_state(yaw_testbed(), float(found.best.wheel[0]))
    return open_loop(structure, theta, found.best.command[:-1], share * found.time, start)


def left_open(folder: Path) -> None:
    """Section "future work": friction fed forward, integral, tuned gains, momentum dumping."""
    for name, law in laws().items():
        w = wave(20.0, law)
        row(
            f"20 deg, {name}: kp, ki, kd; overshoot out, back, error that stays out, back [deg]",
            "",
            f"{law.kp:.0f}, {law.ki:.0f}, {law.kd:.1f}; {w.over[0]:.2f}, {w.over[1]:.2f}; "
            f"{np.degrees(float(w.out[0].error)):.3f}, {np.degrees(float(w.back[0].error)):.3f}",
        )
    found = dump(yaw_testbed(), TOP, Limits(VOLTS, AMPS))
    row(
        "wheel from 4000 rpm to rest, axis held: bound, least time found [s]",
        "",
        f"{found.bound:.3f}, {found.time:.3f}",
    )
    for share in (1.0, 0.8):
        moved = np.degrees(np.max(np.abs(np.asarray(rushed(found, share).angle))))
        row(f"… the axis moves by, the same commands in {share:g} of that time [deg]", "", f"{moved:.3g}")
    save(
        draw_courses({"axis held": found.best, "in 0.8 of the time": rushed(found, 0.8)}, "4000 rpm into the bearing"),
        folder,
        "chapter_4_dump",
    )
