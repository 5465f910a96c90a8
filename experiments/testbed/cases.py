"""What the simulated testbed has and its rig file lacks, one case each."""

from dataclasses import replace

from experiments.blind.simulator import Truth
from experiments.testbed.campaign import TRUTH

ESC = {"deadzone": 0.3, "lag": 0.06, "sag": 3.0, "sag_form": 1.0}
"""Of an ESC on a weak battery: V without effect, s, and 3 ohm between a 12 V bus and the bridge."""
CHANGES: dict[str, dict[str, float]] = {
    "none": {},
    "drive.deadzone": {"deadzone": ESC["deadzone"]},
    "drive.lag": {"lag": ESC["lag"]},
    "drive.supply_sag": {"sag": ESC["sag"], "sag_form": ESC["sag_form"]},
    "drive.asymmetric_gain": {"gain_asymmetry": 0.08},
    "drive.bias": {"bias_command": 0.15},
    "axis.stribeck": {"excess": 0.004, "v_s": 0.08},
    "axis.imbalance": {"imbalance": 0.008, "imbalance_phase": 0.7},
    "axis.spring": {"spring": 0.02},
    "axis.quadratic_drag": {"quadratic": 0.02},
    "wheel.coulomb": {"wheel_coulomb": 0.004},
    "wheel.drag": {"wheel_drag": 2e-7},
    "motor.saturation": {"saturation_current": 3.0},
    "sensor.eccentricity": {"eccentricity": 0.03},
    "sensor.delay": {"sensor_delay": 0.04},
    "esc": ESC,
}
"""Numbers of the truth, by the name that a diagnosis should find; `esc` is three of them at once."""


def truth(case: str) -> Truth:
    """The testbed of a case."""
    return replace(TRUTH, **CHANGES[case])


def expected(case: str) -> set[str]:
    """The effects that are missing from the rig file."""
    return {"none": set(), "esc": {"drive.deadzone", "drive.lag", "drive.supply_sag"}}.get(case, {case})
