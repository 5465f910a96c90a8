"""How a motion in closed form is written down, and the rigs and commands of those that the tests know."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rwjax.rig.model import Rig
from tests.effects.rigs import TIME
from tests.systems import wheel as wheel_rig

OPEN = wheel_rig().with_values({"motor.torque_constant": 1e-9, "motor.friction": 0.0})  # as if open: no damping
LOCKED = wheel_rig().with_values({"wheel.inertia": 1e6})
AT_ONCE = LOCKED.with_values({"motor.inductance": 0.0})  # the current is that of the voltage
I, J, R, K = 0.1, 1.24e-4, 0.83, 0.0182
PUSH = np.where(TIME < 1.0, 0.0, 1.0)
AFTER = np.maximum(TIME - 1.0, 0.0)  # s since the push of 4 rad/s2
SETTLED = TIME > 8.0


class Known(NamedTuple):
    """A motion in closed form: `exact(readings)` of one output, to a tolerance, where `when` says."""

    effect: str
    given: dict[str, float]
    rig: Rig
    u: np.ndarray
    start: dict[str, float]
    output: str
    exact: Callable[[dict[str, np.ndarray]], np.ndarray]
    within: float
    when: np.ndarray = TIME >= 0.0


W0 = {"w": 2.0}
ON = np.ones_like(TIME)
PSI, RATE, SPIN, AMPERE = "yaw_rad", "yaw_rad_s", "wheel_rad_s", "current_A"
