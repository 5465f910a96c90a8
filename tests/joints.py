"""Joints for tests: a geared motor with a link, its servo, and logs of it."""

from dataclasses import replace

import numpy as np

from rwjax.kinds import SERVO
from rwjax.logs.log import Log
from rwjax.rig.model import Rig, Servo
from rwjax.simulation.simulate import simulate

COUNT = 2.0 * np.pi / 4096  # rad
NUMBERS = {
    "motor.torque_constant": 0.02,
    "motor.resistance": 2.0,
    "motor.inertia": 1e-6,
    "gear.ratio": 100.0,
    "axis.inertia": 0.01,
    "axis.friction.viscous": 0.02,
}
GAINS = {"kp": 8.0, "period": 0.005}


def joint(**numbers: float) -> Rig:
    """A joint without gravity and dry friction; numbers by name with `__` for dots, of 0 left out."""
    given = NUMBERS | {name.replace("__", "."): value for name, value in numbers.items()}
    return Rig(
        "joint", "joint", {name: value for name, value in given.items() if value}, counts_per_rev={"axis": 4096.0}
    )


def servo(
    rig: Rig, acts_on: str = "voltage", damping_on: str = "error", encoder_side: str = "link", **gains: float
) -> Rig:
    """A rig with a servo; gains by their names in the rig file."""
    numbers = {f"{SERVO}.{name}": value for name, value in (GAINS | gains).items()}
    return replace(rig, numbers=rig.numbers | numbers, servo=Servo(acts_on, damping_on, encoder_side))


def logged(rig: Rig, time: np.ndarray, name: str = "run.csv", **columns: np.ndarray) -> Log:
    """A log of a rig's own run, its position in counts."""
    y = COUNT * np.round(np.asarray(simulate(rig, time, columns)["yaw_rad"]) / COUNT)
    command = next(column for column in columns if column not in ("enabled", "supply_V"))
    on = columns["enabled"] > 0.0 if "enabled" in columns else None
    return Log(
        name,
        time,
        columns[command],
        {"yaw_rad": y},
        {"yaw_rad": COUNT},
        {},
        False,
        columns.get("supply_V"),
        float(time[0]),
        input=command,
        enabled=on,
    )


def as_platform(rig: Rig) -> Rig:
    """The platform that moves under a voltage as a joint without inductance does: gain N K/R, friction b + (N K)²/R."""
    n = rig.numbers
    N, K, R = n["gear.ratio"], n["motor.torque_constant"], n["motor.resistance"]
    numbers = {name: value for name, value in n.items() if name.startswith("axis.")} | {
        "drive.gain": N * K / R,
        "axis.inertia": n["axis.inertia"] + N**2 * n["motor.inertia"],
        "axis.friction.viscous": n["axis.friction.viscous"] + (N * K) ** 2 / R,
    }
    return replace(rig, kind="platform", numbers=numbers, name="the same")
