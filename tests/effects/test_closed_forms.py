"""Every effect: a motion known in closed form."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from rwjax.effects.library import EFFECTS
from rwjax.rig.model import Rig
from tests.effects.rigs import DRY, FREE, REST, TIME, go
from tests.systems import wheel as wheel_rig

OPEN = wheel_rig().with_values({"motor.torque_constant": 1e-9, "motor.friction": 0.0})  # as if open: no damping
LOCKED = wheel_rig().with_values({"wheel.inertia": 1e6})
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


def _lag(T: float) -> np.ndarray:
    return 4.0 * (AFTER - T * (1.0 - np.exp(-AFTER / T)))


def _stop(t: np.ndarray) -> np.ndarray:
    return np.where(t < 1.0 + np.pi / 20.0, 1.0 + np.sin(20.0 * (t - 1.0)) / 20.0, 1.0 - (t - 1.0 - np.pi / 20.0))


def _well(x: np.ndarray) -> np.ndarray:
    return 2.0 * x**2 + 4.0 * x**4


def _angle(y: dict[str, np.ndarray]) -> np.ndarray:
    psi = y["yaw_rad"]
    return np.sqrt(np.maximum(9.0 - 2.0 / I * (0.05 * psi + 0.02 * (1.0 - np.cos(psi))), 0.0))


def _warm(c: float, tau: float, V: float) -> float:
    return 0.5 * (np.sqrt(1.0 + 4.0 * c * tau * (V / R) ** 2) - 1.0)  # q (1 + q) = c tau (V/R)^2


W0 = {"w": 2.0}
ON = np.ones_like(TIME)
PSI, RATE, SPIN, AMPERE = "yaw_rad", "yaw_rad_s", "wheel_rad_s", "current_A"
MOTIONS = [
    Known("axis.viscous", {"b": 0.05}, FREE, REST, W0, RATE, lambda y: 2.0 * np.exp(-0.5 * TIME), 1e-10),
    Known("axis.coulomb", {"M_c": 0.03}, FREE, REST, W0, RATE, lambda y: np.maximum(2.0 - 0.3 * TIME, 0.0), 1e-10),
    Known(
        "axis.stribeck", {"M_c": 0.03, "M_e": 0.0}, FREE, REST, W0, RATE, lambda y: np.maximum(2 - 0.3 * TIME, 0), 1e-10
    ),
    Known("axis.asymmetric_friction", {"d": 0.02}, DRY, REST, W0, RATE, lambda y: np.maximum(2 - 0.7 * TIME, 0), 1e-10),
    Known("axis.quadratic_drag", {"c": 0.05}, FREE, REST, W0, RATE, lambda y: 2.0 / (1.0 + TIME), 1e-5),
    Known(
        "axis.quadratic_drag",
        {"c": 0.05, "p": 1.5},
        FREE,
        REST,
        W0,
        RATE,
        lambda y: (0.5**0.5 + TIME / 4.0) ** -2,
        1e-5,
    ),
    Known("axis.angle_friction", {"s_1": 0.4}, DRY, REST, {"w": 3.0}, RATE, _angle, 1e-5, TIME < 5.0),
    Known("axis.load_friction", {"mu": 0.1}, FREE, PUSH, {}, RATE, lambda y: 3.6 * AFTER, 1e-9),
    Known(
        "axis.friction_drift",
        {"d": 2.0, "tau": 1.0},
        DRY,
        REST,
        W0,
        RATE,
        lambda y: 1.0 + np.exp(-TIME) - 0.5 * TIME,
        1e-5,
        TIME < 2.0,
    ),
    Known(
        "axis.friction_drift",
        {"d": 0.0, "B": 0.1, "tau": 1.0},
        FREE,
        REST,
        W0,
        RATE,
        lambda y: 2.0 * np.exp(np.exp(-TIME) - 1.0),
        1e-4,
    ),
    Known(
        "axis.friction_drift",
        {"d": 2.0, "tau": 1.5, "s": 1.0},
        DRY,
        REST,
        W0,
        RATE,
        lambda y: 2.0 - 0.5 * TIME - np.where(TIME < 1.5, TIME - TIME**2 / 3.0, 0.75),
        1e-4,
        TIME < 2.4,
    ),
    Known("axis.imbalance", {"s": 0.4}, FREE, REST, {"psi": 1e-3}, PSI, lambda y: 1e-3 * np.cos(2.0 * TIME), 1e-7),
    Known("axis.spring", {"k": 0.4, "T_0": 0.2}, FREE, REST, {}, PSI, lambda y: 0.5 - 0.5 * np.cos(2.0 * TIME), 1e-9),
    Known(
        "axis.spring",
        {"k": 0.4, "T_0": 0.2, "k_3": 1.6},
        FREE,
        REST,
        {},
        PSI,  # off by what its energy is off
        lambda y: y[PSI] + 0.5 * y[RATE] ** 2 + _well(y[PSI] - 0.5) - 0.75,
        1e-4,
    ),
    Known("axis.bias_torque", {"T": -0.08}, FREE, REST, {}, RATE, lambda y: -0.8 * TIME, 1e-10),
    Known(
        "axis.end_stop",
        {"high": 1.0, "k": 40.0, "d": 0.0},
        FREE,
        REST,
        {"w": 1.0},
        PSI,
        lambda y: np.where(TIME < 1.0, TIME, _stop(TIME)),
        1e-2,
        TIME < 3.0,
    ),
    Known(
        "axis.periodic_torque",
        {"s": 0.1, "omega": 4.0},
        FREE,
        REST,
        {},
        RATE,
        lambda y: 0.25 * (1.0 - np.cos(4.0 * TIME)),
        1e-4,
    ),
    Known(
        "axis.periodic_torque",
        {"s": 0.1, "omega": 4.0, "p": 0.4, "q": 0.2},
        FREE,
        REST,
        {},
        RATE,
        lambda y: 0.25 * (1.0 - np.cos(4.0 * TIME)) + 0.05 * (1.0 - np.cos(8.0 * TIME)) + 0.025 * np.sin(8.0 * TIME),
        1e-4,
    ),
    Known("wheel.drag", {"c": 1e-5}, OPEN, REST, {"Omega": 30.0}, SPIN, lambda y: 30.0 / (1.0 + 3e-4 / J * TIME), 1e-3),
    Known(
        "wheel.cogging",
        {"s": -1e-3, "n": 6.0},
        OPEN,
        REST,
        {"theta": 1e-3},
        "wheel_rad",
        lambda y: 1e-3 * np.cos(np.sqrt(6e-3 / J) * TIME),
        2e-6,
    ),
    Known(
        "wheel.cogging",
        {"s": -1e-3, "n": 6.0, "p": 0.5},
        OPEN,
        REST,
        {"theta": 1e-3},
        "wheel_rad",
        lambda y: 1e-3 * np.cos(np.sqrt(12e-3 / J) * TIME),
        2e-6,
    ),
    Known(
        "motor.heating",
        {"c": 0.5, "tau": 0.5},
        LOCKED,
        ON,
        {},
        AMPERE,
        lambda y: ON / R / (1.0 + _warm(0.5, 0.5, 1.0)),
        1e-6,
        SETTLED,
    ),
    Known(
        "motor.saturation",
        {"a": 0.5},
        LOCKED,
        ON,
        {},
        SPIN,
        lambda y: K / R / (1 + 0.5 / R**2) / 1e6 * (TIME - 8) + y[SPIN][800],
        1e-12,
        SETTLED,
    ),
    Known("motor.current_limit", {"i_m": 0.9}, LOCKED, ON, {}, AMPERE, lambda y: 0.9 * ON, 1e-12, SETTLED),
    Known("drive.lag", {"T": 0.2}, FREE, PUSH, {}, RATE, lambda y: _lag(0.2), 1e-9),
    Known("drive.lag", {"T": 0.2, "q": 0.5}, FREE, PUSH, {}, RATE, lambda y: 2.0 * _lag(0.2) - _lag(0.1), 1e-4),
    Known(
        "drive.rate_limit",
        {"r": 2.0},
        FREE,
        PUSH,
        {},
        RATE,
        lambda y: np.where(AFTER < 0.5, 4.0 * AFTER**2, 4.0 * AFTER - 1.0),
        1e-9,
    ),
    Known("drive.delay", {"tau": 0.043}, FREE, PUSH, {}, RATE, lambda y: 4.0 * np.maximum(AFTER - 0.043, 0.0), 1e-9),
    Known("drive.saturation", {"u_m": 0.5}, FREE, PUSH, {}, RATE, lambda y: 2.0 * AFTER, 1e-9),
    Known(
        "drive.saturation", {"u_m": 2.0, "n": 2.0}, FREE, PUSH, {}, RATE, lambda y: 4.0 / np.sqrt(1.25) * AFTER, 1e-9
    ),
    Known("drive.bias", {"u_b": -0.2}, FREE, REST, {}, RATE, lambda y: -0.8 * TIME, 1e-9),
    Known("drive.deadzone", {"u_0": 0.3}, FREE, -PUSH, {}, RATE, lambda y: -2.8 * AFTER, 1e-9),
    Known("drive.deadzone", {"u_0": 0.0, "j": 0.3}, FREE, -PUSH, {}, RATE, lambda y: -4.0 * AFTER, 1e-9),
    Known("drive.asymmetric_gain", {"a": 0.1}, FREE, -PUSH, {}, RATE, lambda y: -3.6 * AFTER, 1e-9),
    Known("drive.curvature", {"c": 0.25}, FREE, -PUSH, {}, RATE, lambda y: -5.0 * AFTER, 1e-9),
    Known("drive.curvature", {"c": -0.25}, FREE, PUSH, {}, RATE, lambda y: 3.2 * AFTER, 1e-9),
    Known("drive.curvature", {"c": 0.25, "p": 0.5, "u_1": 4.0}, FREE, -PUSH, {}, RATE, lambda y: -2.5 * AFTER, 1e-9),
    Known("drive.supply_sag", {"rho": 0.2}, LOCKED, ON, {}, AMPERE, lambda y: ON / (R + 0.2), 1e-8, SETTLED),
    Known("sensor.scale", {"s": 0.1}, FREE, REST, W0, PSI, lambda y: 2.2 * TIME, 1e-9),
    Known(
        "sensor.eccentricity",
        {"s": 0.1, "c": 0.05},
        FREE,
        REST,
        W0,
        PSI,
        lambda y: 2 * TIME + 0.1 * np.sin(2 * TIME) + 0.05 * np.cos(2 * TIME),
        1e-9,
    ),
    Known(
        "sensor.eccentricity",
        {"s_2": 0.1, "c_2": 0.05},
        FREE,
        REST,
        W0,
        PSI,
        lambda y: 2 * TIME + 0.1 * np.sin(4 * TIME) + 0.05 * np.cos(4 * TIME),
        1e-9,
    ),
    Known("sensor.delay", {"tau": 0.037}, FREE, REST, W0, PSI, lambda y: 2.0 * (TIME - 0.037), 1e-9),
    Known(
        "sensor.delay", {"tau": 0.037}, FREE, PUSH, {}, PSI, lambda y: 2.0 * np.maximum(AFTER - 0.037, 0.0) ** 2, 1e-9
    ),
    Known(
        "sensor.missed_counts",
        {"s": 0.3, "w_m": 1.5, "j": 0.1},
        FREE,
        REST,
        {"w": -2.0},
        PSI,
        lambda y: -(2.0 - 0.15 - 0.15) * TIME,
        1e-9,
    ),
    Known("sensor.clock", {"e": 0.1}, FREE, REST, W0, PSI, lambda y: 1.8 * TIME, 1e-9),
    Known("sensor.clock", {"e": -0.1}, FREE, ON, {}, RATE, lambda y: 4.4 * TIME, 1e-9),
    Known(
        "axis.flexible_coupling",
        {"s": 0.4, "k": 2.4, "c": 0.0},
        FREE,
        REST,
        {"axis.flexible_coupling:twist": 0.1},
        PSI,
        lambda y: 0.04 * (1.0 - np.cos(10.0 * TIME)),
        1e-9,
    ),
    Known(
        "axis.backlash",
        {"g": 0.2, "s": 0.25, "k": 1e3, "c": 1.0},
        FREE,
        ON,
        {},
        PSI,
        lambda y: 0.0 * TIME,
        1e-12,
        np.sqrt(0.2 * 0.025 / 0.4) - 0.01 > TIME,
    ),
    Known(
        "axis.backlash",
        {"g": 0.2, "s": 0.25, "k": 1e3, "c": 5.0},
        FREE,
        ON,
        {},
        PSI,
        lambda y: 2.0 * TIME**2 - 0.25 * 0.1,
        5e-3,
        TIME > 2.0,
    ),
]
ELSEWHERE = {"axis.presliding", "wheel.coulomb"}


@pytest.mark.parametrize("known", MOTIONS, ids=lambda known: known.effect)
def test_the_motion_is_that_of_the_closed_form(known: Known) -> None:
    y = go(known.rig, known.u, known.start, {known.effect: known.given})
    error = np.abs(y[known.output] - known.exact(y))[known.when]
    assert np.max(error) < known.within * max(1.0, float(np.max(np.abs(y[known.output]))))


def test_every_effect_has_a_known_motion() -> None:
    assert {known.effect for known in MOTIONS} | ELSEWHERE == {effect.name for effect in EFFECTS}
