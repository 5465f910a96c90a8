"""Whole rig files, logs, plans and streams, of every kind, which are then damaged."""

import gzip
import io
from collections.abc import Callable

import numpy as np
import polars as pl
from scipy.io import savemat

from tests.link.ports import LIKE_RIG, stream

MOTOR = "torque_constant = 0.0182\nresistance = 0.83\n"
PLATFORM = """kind = "platform"
name = "thesis platform"
[drive]
gain = 0.428
pwm = { neutral_us = 1500, volts_per_us = 0.02 }
[axis]
inertia = 0.228
[axis.friction]
viscous = 0.082
[encoder]
counts_per_rev = 2048
[columns]
position = "pos1"
pulse = "pwm_1"
[fit]
free = ["axis.inertia", "axis.friction.viscous"]
"""
FRICTION = """kind = "platform"
name = "with everything"
[drive]
gain = 0.428
[axis]
inertia = 0.228
[axis.friction]
viscous = 0.082
coulomb = 0.01
static = 0.02
stribeck_velocity = 0.3
[axis.gravity]
torque = 0.1
angle = 0.2
[encoder]
counts_per_rev = 2048
[fit]
free = ["axis.inertia", "axis.friction.coulomb"]
per_run = ["axis.friction.coulomb"]
[fit.bounds]
"axis.inertia" = [0.1, 0.5]
[fit.prior]
"axis.inertia" = [0.2, 0.05]
[fit.standard_error]
"axis.inertia" = 0.001
"axis.friction.coulomb" = inf
[effects."axis.presliding"]
M_c = 0.02
x_s = 0.01
s = 0.5
d = 0.001
"""
POLYNOMIAL = """kind = "platform"
drive.gain = -0.428
axis.inertia = 0.228
axis.friction.polynomial = [0.01, 0.08, -0.01, 0.002]
encoder.counts_per_rev = 2048
fit.free = ["axis.friction.polynomial"]
"""
WHEEL = f"""kind = "wheel"
name = "wheel alone"
[motor]
{MOTOR}inductance = 0.0641
friction = 4.07e-6
[wheel]
inertia = 1.24e-4
[wheel_encoder]
counts_per_rev = 1024
[fit]
free = ["wheel.inertia", "motor.friction"]
[fit.prior]
"wheel.inertia" = [1.2e-4, 1e-5]
[effects."wheel.coulomb"]
M_c = 0.001
"""
REACTION = f"""kind = "reaction"
name = "testbed"
[motor]
{MOTOR}friction = 4.07e-6
[wheel]
inertia = 1.24e-4
[drive]
pwm = {{ neutral_us = 1500, volts_per_us = 0.02 }}
[axis]
inertia = 0.0495
[axis.friction]
viscous = 0.0026
coulomb = 0.004
[encoder]
counts_per_rev = 2048
[wheel_encoder]
counts_per_rev = 1024
[columns]
position = "pos2"
pulse = "pwm_2"
[fit]
free = ["axis.inertia", "axis.friction.viscous"]
[effects."drive.delay"]
tau = 0.003
"""
TWO_AXIS = "\n".join(
    [
        'kind = "two_axis"',
        'name = "two axes"',
        *(
            "[yaw]",
            "inertia = 0.0495",
            "friction.viscous = 0.003",
            "[pitch]",
            "inertia = 0.021",
            "friction.viscous = 0.002",
        ),
        *("[pitch.gravity]", "torque = 0.12", "[gimbal]", "difference = -0.012", "product_xz = 0.002"),
        *("[motor_1]", MOTOR, "[wheel_1]", "inertia = 1.24e-4", "[motor_2]", MOTOR, "[wheel_2]", "inertia = 1.24e-4"),
        *("[yaw_encoder]", "counts_per_rev = 4096", "[pitch_encoder]", "counts_per_rev = 4096"),
        *("[fit]", 'free = ["yaw.inertia", "pitch.inertia"]'),
    ]
)
COLUMNS = """kind = "platform"
name = "as an Arduino logs it"
[drive]
gain = 0.428
supply = 12.0
[axis]
inertia = 0.228
[axis.friction]
viscous = 0.082
[encoder]
counts_per_rev = 2048
[columns]
time_s = { column = "ms", unit = "ms" }
voltage_V = { column = "pwm", scale = "12 V / 255", offset = 1.0 }
yaw_counts = "counts"
yaw_rad_s = { column = "rpm", unit = "rpm", sign = -1 }
supply_V = { column = "battery", unit = "mV", scale = 1.0 }
[fit]
free = ["axis.inertia"]
"""
JOINT = """kind = "joint"
name = "servo"
[gear]
ratio = 200.0
[motor]
torque_constant = 0.01
resistance = 4.0
[axis]
inertia = 0.02
[axis.friction]
viscous = 0.1
[drive]
supply = 7.4
[drive.servo]
acts_on = "duty"
kp = 8.0
period = 0.01
[columns]
time_s = { column = "ms", unit = "ms" }
goal_rad = { column = "counts", scale = "1/2048", unit = "turn" }
position_rad = { column = "pwm", unit = "deg" }
current_A = { column = "battery", unit = "mA", unsigned = true }
[fit]
free = ["axis.inertia"]
"""
RIGS = {
    "columns": COLUMNS,
    "joint": JOINT,
    "platform": PLATFORM,
    "friction": FRICTION,
    "polynomial": POLYNOMIAL,
    "wheel": WHEEL,
    "reaction": REACTION,
    "two axes": TWO_AXIS,
}
"""Rig files by what they are."""
SAMPLES = 60
"""Rows of a log, so few that a free run takes a few milliseconds."""


def _columns() -> dict[str, np.ndarray]:
    """Columns of all logs by name: a square wave, and readings that follow it as those of some rig may."""
    n = np.arange(SAMPLES)
    time, volts = 0.01 * n, np.where(n < 5, 0.0, np.where((n // 20) % 2, -2.0, 2.0))
    rate = np.convolve(volts, 0.2 * 0.9 ** np.arange(SAMPLES))[:SAMPLES]
    angle = np.cumsum(rate) * 0.01
    turns = {"yaw": angle, "pitch": -angle, "wheel": 40.0 * angle}
    counts = {f"{name}_counts": np.rint(turn * 2048 / (2 * np.pi)) for name, turn in turns.items()}
    rates = {"yaw_rad_s": rate, "wheel_rad_s": 40.0 * rate, "wheel_1_rad_s": 40.0 * rate, "wheel_2_rad_s": -40.0 * rate}
    return {
        "time_s": time,
        "voltage_V": volts,
        "voltage_1_V": volts,
        "voltage_2_V": -volts,
        "supply_V": 12.0 - 0.01 * n,
        "current_A": np.round(volts - 0.7 * rate, 4),
        **counts,
        **{name: np.round(value, 4) for name, value in rates.items()},
    }


def _log(*names: str, notes: str = "") -> str:
    columns = _columns()
    rows = zip(*(columns[name].tolist() for name in names), strict=True)
    return notes + "\n".join([",".join(names), *(",".join(f"{x:.10g}" for x in row) for row in rows), ""])


def _thesis() -> str:
    columns = _columns()
    angle, pulse = columns["yaw_counts"].astype(int), np.rint(1500 + columns["voltage_V"] / 0.02).astype(int)
    rows = [f"{7 * k};{a};{-a};0;{p};{p}" for k, (a, p) in enumerate(zip(angle, pulse, strict=True))]
    return "\n".join(["t;pos1;pos2;speed2;pwm_1;pwm_2", *rows, ""])


def _foreign() -> dict[str, np.ndarray]:
    """Columns as a logger names them, in its own units."""
    columns = _columns()
    return {
        "ms": 1000.0 * columns["time_s"],
        "pwm": np.rint(20.0 * columns["voltage_V"]),
        "counts": columns["yaw_counts"],
        "rpm": np.round(-9.55 * columns["yaw_rad_s"], 2),
        "battery": 1000.0 * columns["supply_V"],
    }


def _text(separator: str, decimal: str) -> str:
    columns = _foreign()
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    cells = (separator.join(f"{x:.10g}" for x in row).replace(".", decimal) for row in rows)
    return "\n".join([separator.join(columns), *cells, ""])


def _saved(save: Callable[[io.BytesIO], object]) -> bytes:
    file = io.BytesIO()
    save(file)
    return file.getvalue()


FORMS = {
    "gz": gzip.compress(_text(";", ",").encode(), mtime=0),
    "parquet": _saved(lambda file: pl.DataFrame(_foreign()).write_parquet(file)),
    "npz": _saved(lambda file: np.savez(file, **_foreign())),
    "mat": _saved(lambda file: savemat(file, {"run": _foreign()})),
    "utf16": _text("\t", ",").encode("utf-16"),
    "quoted": _text(";", ",").replace(";", '";"').replace("\n", '"\n"').encode(),
}
"""Logs of the rigs "columns" and "joint" that are no plain text."""
NOTES = "# simulated: here\n# add axis.inertia: 0.01\n# role: train\n# ignore: supply_V\n"
LOGS = {
    "columns": (_text(",", "."), _text(";", ",")),
    "joint": (_text(";", "."), _text("\t", ",")),
    "platform": (_log("time_s", "voltage_V", "yaw_counts", notes=NOTES.replace("# ignore: supply_V\n", "")), _thesis()),
    "friction": (_log("time_s", "voltage_V", "yaw_counts", "yaw_rad_s", "supply_V"),),
    "polynomial": (_log("time_s", "voltage_V", "yaw_counts"),),
    "wheel": (_log("time_s", "voltage_V", "wheel_rad_s", "current_A", "supply_V"),),
    "reaction": (
        _log("time_s", "voltage_V", "yaw_counts", "wheel_rad_s", "current_A", "supply_V", notes=NOTES),
        _log("time_s", "voltage_V", "yaw_rad_s", "wheel_counts"),
        _thesis(),
    ),
    "two axes": (
        _log("time_s", "voltage_1_V", "voltage_2_V", "yaw_counts", "pitch_counts", "wheel_1_rad_s", "wheel_2_rad_s"),
    ),
}
"""Logs of each of `RIGS`."""
STILL = "time_s,voltage_V,yaw_counts\n" + "".join(f"{k / 100},0.0,{5 + (k * 7919) % 3}\n" for k in range(60))
"""A log of a platform that stands still, of which a diagnosis takes seconds."""
PLAN = """schema = "rwjax.plan/1"
rig = "testbed"
[limits]
voltage_V = 12.0
yaw_rad = 0.7
[[runs]]
name = "triangle"
kind = "triangle"
amplitude_V = 3.1
offset_V = 0.1
period_s = 2.0
length_s = 4.0
role = "train"
why = "slow through standstill"
tells_apart = ["axis.stribeck", "axis.coulomb"]
reaches = { yaw_rad = 0.4, wheel_rad_s = 100.0 }
way_rad = [-0.4, 0.1]
[[runs]]
name = "square-2"
kind = "square"
amplitude_V = 2.0
period_s = 1.0
length_s = 2.0
role = "validate"
"""
STREAM = stream(range(100, 100 + SAMPLES), LIKE_RIG)
"""Frames of a board on which `tests.link.ports.RIG` hangs."""
