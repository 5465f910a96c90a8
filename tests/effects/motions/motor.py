"""Effects in the motor: motions in closed form."""

import numpy as np

from tests.effects.known import AMPERE, LOCKED, ON, SETTLED, SPIN, K, Known, R
from tests.effects.rigs import TIME


def _warm(c: float, tau: float, V: float) -> float:
    return 0.5 * (np.sqrt(1.0 + 4.0 * c * tau * (V / R) ** 2) - 1.0)  # q (1 + q) = c tau (V/R)^2


MOTIONS = [
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
    Known(
        "motor.saturation",
        {"a": 0.5, "m": 0.5},
        LOCKED,
        ON,
        {},
        SPIN,
        lambda y: K / np.sqrt(R**2 + 0.5) / 1e6 * (TIME - 8) + y[SPIN][800],
        1e-12,
        SETTLED,
    ),
    Known("motor.current_limit", {"i_m": 0.9}, LOCKED, ON, {}, AMPERE, lambda y: 0.9 * ON, 1e-12, SETTLED),
]
