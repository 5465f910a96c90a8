"""Effects between wheel and body: motions in closed form."""

import numpy as np

from tests.effects.known import OPEN, SPIN, J, Known
from tests.effects.rigs import REST, TIME

MOTIONS = [
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
        "wheel.coulomb",
        {"M_c": 1e-3},
        OPEN,
        REST,
        {"Omega": 30.0},
        SPIN,
        lambda y: np.maximum(30.0 - 1e-3 / J * TIME, 0.0),
        1e-9,
    ),
]
