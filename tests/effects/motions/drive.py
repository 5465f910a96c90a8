"""Effects on the command: motions in closed form."""

import numpy as np

from tests.effects.known import AFTER, AMPERE, AT_ONCE, LOCKED, ON, PUSH, RATE, SETTLED, Known, R
from tests.effects.rigs import FREE, REST, TIME


def _lag(T: float) -> np.ndarray:
    return 4.0 * (AFTER - T * (1.0 - np.exp(-AFTER / T)))


def _sagged(rho: float, m: float, tau: float) -> np.ndarray:
    """At 1 V and 1 A the drop is ρ (1 − m exp(−t/τ))."""
    return 4.0 * ((1.0 - rho) * AFTER + rho * m * tau * (1.0 - np.exp(-AFTER / tau)))


SAG = {"rho": 0.2, "m": 0.7, "tau": 1.5}
WAVE = np.where(TIME < 5.0, 1.0, -1.0)
MOTIONS = [
    Known("drive.lag", {"T": 0.2}, FREE, PUSH, {}, RATE, lambda y: _lag(0.2), 1e-9),
    Known("drive.lag", {"T": 0.2, "q": 0.5}, FREE, PUSH, {}, RATE, lambda y: 2.0 * _lag(0.2) - _lag(0.1), 1e-4),
    Known("drive.lag", {"T": 0.008}, AT_ONCE, PUSH, {}, AMPERE, lambda y: (1.0 - np.exp(-AFTER / 0.008)) / R, 0.01),
    Known(
        "drive.rate_limit", {"r": 20.0}, AT_ONCE, PUSH, {}, AMPERE, lambda y: np.minimum(20.0 * AFTER, 1.0) / R, 0.005
    ),
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
    Known("drive.square_law", {"s": 1.0, "u_1": 4.0}, FREE, -0.5 * PUSH, {}, RATE, lambda y: -0.25 * AFTER, 1e-9),
    Known("drive.square_law", {"s": 0.5, "u_1": 4.0}, FREE, 2.0 * PUSH, {}, RATE, lambda y: 6.0 * AFTER, 1e-9),
    Known("drive.one_sided", {"s": 1.0}, FREE, WAVE, {}, RATE, lambda y: 4.0 * np.minimum(TIME, 5.0), 1e-9),
    Known("drive.one_sided", {"s": -1.0}, FREE, WAVE, {}, RATE, lambda y: -4.0 * np.maximum(TIME - 5.0, 0.0), 1e-9),
    Known("drive.one_sided", {"s": 0.25}, FREE, -PUSH, {}, RATE, lambda y: -3.0 * AFTER, 1e-9),
    Known("drive.supply_sag", {"rho": 0.2}, LOCKED, ON, {}, AMPERE, lambda y: ON / (R + 0.2), 1e-8, SETTLED),
    Known("drive.supply_sag", {"rho": 0.2}, FREE, -PUSH, {}, RATE, lambda y: -_sagged(0.2, 0.0, 1.0), 1e-9),
    Known("drive.supply_sag", SAG, FREE, PUSH, {}, RATE, lambda y: _sagged(**SAG), 1e-5),
]
