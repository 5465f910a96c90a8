"""Loads, couplings and stops of the axis: motions in closed form."""

import numpy as np

from tests.effects.known import ON, PSI, RATE, Known
from tests.effects.rigs import FREE, REST, TIME


def _stop(t: np.ndarray) -> np.ndarray:
    return np.where(t < 1.0 + np.pi / 20.0, 1.0 + np.sin(20.0 * (t - 1.0)) / 20.0, 1.0 - (t - 1.0 - np.pi / 20.0))


def _well(x: np.ndarray) -> np.ndarray:
    return 2.0 * x**2 + 4.0 * x**4


MOTIONS = [
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
