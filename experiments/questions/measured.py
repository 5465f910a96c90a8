"""Published runs of real rigs as logs, each with a rig file of the numbers that its source gives.

They are right as they are: units converted, time in seconds, each with its own command.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from experiments.realdata import dcmotor, emps, need
from rwjax import parse_rig, read_logs
from rwjax.logs.log import Log
from rwjax.logs.write import write_log
from rwjax.rig.model import Rig

TURN = 2.0 * np.pi
DEGREE = np.pi / 180.0


class Source(NamedTuple):
    """Runs of one rig.

    Attributes:
        files: The files, below the folder of the published logs, as a pattern.
        columns: Index of the column in the file and its factor to SI, by name of the log's column.
        rig: The rig file.
        unsigned: Column that lost its sign, which is that of the command.
    """

    files: str
    columns: dict[str, tuple[int, float]]
    rig: str
    unsigned: str = ""


def _platform(inertia: float, gain: float, viscous: float, coulomb: float, gravity: float = 0.0) -> str:
    """The text of a rig file."""
    text = f'kind = "platform"\n[drive]\ngain = {gain}\n[axis]\ninertia = {inertia}\n[axis.friction]\nviscous = {viscous}\n'
    text += f"coulomb = {coulomb}\n" if coulomb else ""
    return text + (f"[axis.gravity]\ntorque = {gravity}\n" if gravity else "") + '[fit]\nfree = ["axis.inertia"]\n'


def _wheel(inertia: float, constant: float, resistance: float, friction: float) -> str:
    """The text of a motor's rig file."""
    motor = f"torque_constant = {constant}\nresistance = {resistance}\nfriction = {friction}\n"
    return f'kind = "wheel"\n[motor]\n{motor}[wheel]\ninertia = {inertia}\n[fit]\nfree = ["wheel.inertia"]\n'


SOURCES = {
    "Quanser AERO": Source(
        "quanser_aero_pitch/*.csv",
        {"time_s": (0, 1.0), "voltage_V": (1, 1.0), "yaw_rad": (2, 1.0)},
        _platform(0.02189, 1.09e-3, 0.0056, 0.0, 0.09),
    ),
    "HSM150": Source(  # a torque is its command: volts stand for N m
        "hsm150_servo/idf_*.csv",
        {"time_s": (0, 1.0), "voltage_V": (1, 1.0), "yaw_rad": (4, 1.0), "yaw_rad_s": (5, 1.0)},
        _platform(1.2e-4, 1.0, 7.03e-5, 0.02),
    ),
    "quarter drone": Source(  # command in percent, thrust about linear near 36 degrees
        "quarter_drone_pitch/*.csv",
        {"time_s": (0, 1.0), "voltage_V": (1, 1.0), "yaw_rad": (2, DEGREE)},
        _platform(0.0072, 0.004, 0.0116, 0.0, 0.26),
    ),
    "CE109 hoop": Source(  # 1 is 10 V; the tachometer's volts count as rad/s
        "ce109_hoop_dcmotor/*.csv",
        {"time_s": (0, 1.0), "voltage_V": (1, 10.0), "yaw_rad_s": (2, 1.0)},
        _platform(1.0, 1.0, 1.0, 0.0),
    ),
    "DFKI pendulum": Source(  # a torque is its command
        "dfki_simple_pendulum/*.csv",
        {"time_s": (0, 1.0), "voltage_V": (6, 1.0), "yaw_rad": (1, 1.0)},
        _platform(0.06259, 1.0, 0.04707, 0.289, 1.0),
    ),
    "DFKI double pendulum, first joint": Source(  # the second one hangs free or is driven: a load that is not modelled
        "dfki_double_pendulum/*.csv",
        {"time_s": (0, 1.0), "voltage_V": (1, 1.0), "yaw_rad": (7, 1.0)},
        _platform(0.12, 1.0, 0.004, 0.17, 2.4),
    ),
    "HVA wheel": Source(  # a count of 255 is 12 V
        "hva_reaction_wheel_pendulum/t1_pwm_ramp_*.csv",
        {"time_s": (0, 1.0), "voltage_V": (1, 12.0 / 255.0), "wheel_rad_s": (2, TURN / 60.0)},
        _wheel(1e-3, 0.15, 6.0, 1e-3),
        unsigned="wheel_rad_s",
    ),
    "motor and generator": Source(  # a sample is taken to last 1 ms
        "dcmotor_generator/*.csv",
        {"time_s": (0, 1e-3), "voltage_V": (1, 1.0), "yaw_rad_s": (2, TURN / 60.0)},
        _platform(1.0, 122.0, 1.0, 0.0),
    ),
}
"""Sources by name of the rig."""
MOST_SAMPLES = 60_000
"""Samples of a run that are taken."""


NAMES = ("emps", "dcmotor", *SOURCES)
"""Names of all rigs."""


def measured(folder: Path) -> Iterator[tuple[str, Rig, tuple[Log, ...]]]:
    """The runs of every rig, by way of log files written into a folder."""
    for name in NAMES:
        rig = rig_of(name)
        yield name, rig, runs_of(name, rig, folder)


def rig_of(name: str) -> Rig:
    """The rig file of one of `NAMES`."""
    if name in SOURCES:
        return parse_rig(SOURCES[name].rig, f"{name}.toml")
    return parse_rig((Path(__file__).parents[1] / name / "rig.toml").read_text(), f"{name}.toml")


def runs_of(name: str, rig: Rig, folder: Path) -> tuple[Log, ...]:
    """The runs of one of `NAMES`, by way of log files written into a folder."""
    if name in SOURCES:
        files = [path for path in sorted(need().glob(SOURCES[name].files)) if path.name != "manifest.csv"]
        return read_logs([_log(path, SOURCES[name], folder) for path in files], rig)
    return read_logs(emps(folder) if name == "emps" else [dcmotor(folder)], rig)


def _log(path: Path, source: Source, folder: Path) -> Path:
    """One run as a log file; rows whose time does not increase are left out."""
    table = np.genfromtxt(path, delimiter=",", skip_header=1)[:MOST_SAMPLES]
    table = table[np.append(True, np.diff(np.maximum.accumulate(table[:, 0])) > 0.0)]
    target = folder / f"{path.parent.name}_{path.name}"
    log = {name: factor * table[:, k] for name, (k, factor) in source.columns.items()}
    if source.unsigned:
        log[source.unsigned] *= np.sign(log["voltage_V"])
    write_log(target, log)
    return target
