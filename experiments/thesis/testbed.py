"""The thesis's rig, `data/thesis/yaw.toml`: its numbers, and the testbed of chapter 4 with the inductance of listing A.4."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from rwjax import Rig, read_rig

RIG = read_rig(Path(__file__).parents[2] / "data" / "thesis" / "yaw.toml")
K, R, J, INERTIA = (
    RIG.numbers[name] for name in ("motor.torque_constant", "motor.resistance", "wheel.inertia", "axis.inertia")
)  # N m/A, ohm, kg m2, kg m2
L_CHAPTER_4 = 0.1  # H, listing A.4
TOP = 4000.0 * 2.0 * np.pi / 60.0  # rad/s, eq. 2.1
VOLTS = 10.0  # V, limit of the thesis's tests
AMPS = 3.0  # A, listing A.3


def yaw_testbed(inductance: float = L_CHAPTER_4, friction: bool = True) -> Rig:
    """The rig; without inductance where it is 0, on a frictionless axis where there is to be none."""
    kept = {name: value for name, value in RIG.numbers.items() if friction or not name.startswith("axis.friction.")}
    return replace(RIG, name="thesis, chapter 4", numbers=kept | {"motor.inductance": inductance}, free=())
