"""Effects on the reading: motions in closed form."""

import numpy as np

from tests.effects.known import AFTER, AMPERE, LOCKED, ON, PSI, PUSH, RATE, SETTLED, SPIN, W0, Known, R
from tests.effects.rigs import FREE, REST, TIME

MOTIONS = [
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
    Known("sensor.offset", {"w_b": 0.3, "i_b": 5.0}, FREE, REST, W0, RATE, lambda y: 0.0 * TIME + 2.3, 1e-9),
    Known("sensor.offset", {"w_b": 0.3}, FREE, REST, W0, PSI, lambda y: 2.0 * TIME, 1e-9),
    Known("sensor.offset", {"i_b": 0.2, "Omega_b": 3.0}, LOCKED, ON, {}, AMPERE, lambda y: ON / R + 0.2, 1e-8, SETTLED),
    Known("sensor.offset", {"i_b": 0.2, "Omega_b": 3.0}, LOCKED, ON, {}, SPIN, lambda y: 0.0 * TIME + 3.0, 1e-4),
    Known("sensor.clock", {"e": 0.1}, FREE, REST, W0, PSI, lambda y: 1.8 * TIME, 1e-9),
    Known("sensor.clock", {"e": -0.1}, FREE, ON, {}, RATE, lambda y: 4.4 * TIME, 1e-9),
]
