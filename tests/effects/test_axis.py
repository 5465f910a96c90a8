"""Loads and stops of the axis beside their closed forms."""

import numpy as np

from tests.effects.rigs import FREE, REST, TIME, go
from tests.systems import platform, record, run


def test_an_end_stop_takes_energy_and_never_pulls() -> None:
    stop = {"axis.end_stop": {"high": 1.0, "low": -1.0, "k": 40.0, "d": 1.0}}
    y = go(FREE, REST, {"w": 1.0}, stop)
    assert (
        -1.0 < y["yaw_rad_s"][TIME > 1.5][0] < -0.3 and np.min(y["yaw_rad"]) > -1.05
    )  # back, and off the other stop too
    away = (np.abs(y["yaw_rad"]) < 0.98)[1:] & (np.abs(y["yaw_rad"]) < 0.98)[:-1]
    assert np.max(np.abs(np.diff(y["yaw_rad_s"])[away])) < 1e-12


def test_a_constant_torque_below_breakaway_turns_nothing() -> None:
    y = run(platform(), record(TIME, REST), {}, effects={"axis.bias_torque": {"T": -0.049}})
    assert np.ptp(y["yaw_rad"]) == 0.0
