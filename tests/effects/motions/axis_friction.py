"""Friction of the axis: motions in closed form."""

import numpy as np

from tests.effects.known import AFTER, PSI, PUSH, RATE, W0, I, Known
from tests.effects.rigs import DRY, FREE, REST, TIME


def _angle(y: dict[str, np.ndarray]) -> np.ndarray:
    psi = y["yaw_rad"]
    return np.sqrt(np.maximum(9.0 - 2.0 / I * (0.05 * psi + 0.02 * (1.0 - np.cos(psi))), 0.0))


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
    # elastic up to x_s, as a spring of M_c/x_s
    Known(
        "axis.presliding",
        {"M_c": 0.05, "x_s": 0.5, "s": 1.0},
        FREE,
        REST,
        {"w": 0.2},
        PSI,
        lambda y: 0.2 * np.sin(TIME),
        1e-3,  # the displacement enters a step as the one before has left it: first order
        TIME < 2.0,
    ),
    # elements of several lengths, all elastic: springs of M_c/4x_k side by side, of 0.1 N m/rad together
    Known(
        "axis.presliding",
        {"M_c": 0.05, "x_s": 0.625 / 0.96, "s": 1.0, "r": 0.8},
        FREE,
        REST,
        {"w": 0.2},
        PSI,
        lambda y: 0.2 * np.sin(TIME),
        1e-3,
        TIME < 2.0,
    ),
]
