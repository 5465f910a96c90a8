"""PySINDy: the acceleration as a sparse sum of terms, chosen by STLSQ; the run by RK4."""

import numpy as np
import pysindy as ps
from scipy.signal import savgol_filter

WINDOW, THRESHOLD = 101, 0.02  # samples of the smoothing polynomial; of the coefficients
TERMS = {
    "u": lambda v, u: u,
    "v": lambda v, u: v,
    "sgn v": lambda v, u: np.tanh(v / 2e-3),
    "v|v|": lambda v, u: v * abs(v),
    "v³": lambda v, u: v**3,
    "1": lambda v, u: np.ones_like(v),
}
names: list[str] = []


def fit(t: np.ndarray, u: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Coefficients of the terms."""
    h = t[1] - t[0]
    v, a = (savgol_filter(x, WINDOW, 3, deriv=k, delta=h) for k in (1, 2))
    columns = np.stack([term(v, savgol_filter(u, WINDOW, 3)) for term in TERMS.values()], axis=1)
    size = np.linalg.norm(columns, axis=0) / np.sqrt(len(t))
    optimizer = ps.STLSQ(threshold=THRESHOLD)
    optimizer.fit(columns / size, a[:, None])
    found = optimizer.coef_[0] / size
    names[:] = [name for name, value in zip(TERMS, found, strict=True) if value]
    return found


def run(numbers: np.ndarray, t: np.ndarray, u: np.ndarray, first: float) -> np.ndarray:
    """A free run by RK4."""
    h, state, found = t[1] - t[0], np.array([first, 0.0]), []

    def rates(state: np.ndarray, u: float) -> np.ndarray:
        return np.array([state[1], sum(c * term(state[1], u) for c, term in zip(numbers, TERMS.values(), strict=True))])

    for volts in u:
        found.append(state[0])
        k1 = rates(state, volts)
        k2 = rates(state + h / 2 * k1, volts)
        k3 = rates(state + h / 2 * k2, volts)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(state + h * k3, volts))
    return np.array(found)


def says() -> str:
    """What it names."""
    return "the terms " + ", ".join(names)
