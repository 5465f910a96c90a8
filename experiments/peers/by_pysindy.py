"""PySINDy: the acceleration as a sparse sum of terms, chosen by STLSQ; the run by RK4."""

import numpy as np
import pysindy as ps
from scipy.signal import savgol_filter

from experiments.peers.problems import Log, Problem

SMOOTHED, THRESHOLD = 0.1, 0.02  # s of the smoothing polynomial; of the coefficients
names: list[str] = []


def terms(p: Problem, x: np.ndarray, v: np.ndarray, effort: np.ndarray) -> dict[str, np.ndarray]:
    """The candidates."""
    found = {
        "drive": effort,
        "v": v,
        "sgn v": np.tanh(v / p.width),
        "v|v|": v * abs(v),
        "v³": v**3,
        "1": np.ones_like(v),
    }
    return found | ({"sin x": np.sin(x)} if p.load else {})


def fit(p: Problem) -> np.ndarray:
    """Coefficients of the terms."""
    log, h = p.train, p.train.t[1] - p.train.t[0]
    window = max(int(SMOOTHED / h) // 2 * 2 + 1, 7)
    derivatives = [savgol_filter(log.y, window, 3, deriv=k, delta=h) for k in range(3)]
    x, v, a = derivatives if p.reads == 0 else (0.0 * log.y, *derivatives[:2])
    effort = savgol_filter(np.array([p.effort(np, x[k], u) for k, u in enumerate(log.u)]), window, 3)
    columns = np.stack(list(terms(p, x, v, effort).values()), axis=1)
    size = np.linalg.norm(columns, axis=0) / np.sqrt(len(a))
    optimizer = ps.STLSQ(threshold=THRESHOLD)
    optimizer.fit(columns / size, a[:, None])
    found = optimizer.coef_[0] / size
    names[:] = [name for name, value in zip(terms(p, x, v, effort), found, strict=True) if value]
    return found


def run(p: Problem, z: np.ndarray, log: Log) -> np.ndarray:
    """A free run by RK4."""
    h, s, found = log.t[1] - log.t[0], np.array(p.start(log)), []

    def rates(s: np.ndarray, u: np.ndarray) -> np.ndarray:
        values = terms(p, s[0], s[1], p.effort(np, s[0], u)).values()
        return np.array([s[1], sum(c * value for c, value in zip(z, values, strict=True))])

    for u in log.u:
        found.append(s[p.reads])
        k1 = rates(s, u)
        k2 = rates(s + h / 2 * k1, u)
        k3 = rates(s + h / 2 * k2, u)
        s = s + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(s + h * k3, u))
    return np.array(found)


def says() -> str:
    """What it names."""
    return "the terms " + ", ".join(names)
