r"""Rauch-Tung-Striebel smoother of one reading: an `order`-fold integrated Wiener process seen through white noise.

The intensity of the process maximises the likelihood. Gains do not depend on the readings: a smoother is made once for a
log and then serves any readings at the same times, many draws of them at once.
"""

from dataclasses import dataclass
from math import log

import numpy as np
from scipy.optimize import minimize_scalar

from rwjax.diagnosis.settings import SmootherSettings


@dataclass(frozen=True)
class Smoother:
    """Smoother of a log's readings.

    Attributes:
        ahead: transition of every step (time - 1, a, a).
        gain: gain of every reading (time, a), 0 where one is missing.
        back: gain of every step backward (time - 1, a, a).
        deviation: standard deviation of the smoothed state (time, a) [SI]: value, rate, and acceleration where `a` is 3.
    """

    ahead: np.ndarray
    gain: np.ndarray
    back: np.ndarray
    deviation: np.ndarray

    def __call__(self, y: np.ndarray) -> np.ndarray:
        """Smoothed states of readings.

        Args:
            y: readings (time, …) [SI].

        Returns:
            Smoothed value, rate and acceleration (time, a, …) [SI].
        """
        n, order = self.gain.shape
        many = y.reshape(n, -1)
        x = np.zeros((order, many.shape[1]))
        x[0] = many[np.flatnonzero(np.isfinite(many[:, 0]))[0]]
        y_seen = np.where(np.isfinite(many), many, 0.0)
        X = np.empty((n, order, many.shape[1]))
        predicted = np.empty_like(X)
        for k in range(n):
            if k:
                x = self.ahead[k - 1] @ x
            predicted[k] = x
            x = x + self.gain[k][:, None] * (y_seen[k] - x[0])
            X[k] = x
        for k in range(n - 2, -1, -1):
            X[k] += self.back[k] @ (X[k + 1] - predicted[k + 1])
        return X.reshape(n, order, *y.shape[1:])


_Upper = tuple[float, float, float, float, float, float]
"""Upper triangle of a symmetric matrix of three states, row by row."""


def _process(h: float, q: float, order: int) -> _Upper:
    """Covariance that a step adds."""
    if order == 2:
        return q * h**3 / 3.0, q * h**2 / 2.0, 0.0, q * h, 0.0, 0.0
    return q * h**5 / 20.0, q * h**4 / 8.0, q * h**3 / 6.0, q * h**3 / 3.0, q * h**2 / 2.0, q * h


def _after_step(p: _Upper, h: float, added: _Upper) -> _Upper:
    """Covariance after a step."""
    p00, p01, p02, p11, p12, p22 = p
    q00, q01, q02, q11, q12, q22 = added
    g = 0.5 * h * h
    m01, m02, m12 = p01 + h * p11 + g * p12, p02 + h * p12 + g * p22, p12 + h * p22
    return (
        p00 + h * p01 + g * p02 + h * m01 + g * m02 + q00,
        m01 + h * m02 + q01,
        m02 + q02,
        p11 + h * p12 + h * m12 + q11,
        m12 + q12,
        p22 + q22,
    )


def _after_reading(p: _Upper, r: float) -> tuple[tuple[float, float, float], float, _Upper]:
    """Gain, variance of the innovation, and covariance after a reading of the variance `r`."""
    p00, p01, p02, p11, p12, p22 = p
    s = p00 + r
    k0, k1, k2 = p00 / s, p01 / s, p02 / s
    after = p00 - k0 * p00, p01 - k0 * p01, p02 - k0 * p02, p11 - k1 * p01, p12 - k1 * p02, p22 - k2 * p02
    return (k0, k1, k2), s, after


@dataclass(frozen=True)
class _Model:
    """What is filtered."""

    noise: float  # of the readings [SI]
    q: float  # intensity of the process
    order: int
    settled: float  # relative change of the innovation's variance below which the gain counts as constant


def _filter(y: list[float], steps: list[float], model: _Model, keep: list | None = None) -> float:
    """Twice the negative log likelihood. `keep` receives gain and the covariance before and after every reading.

    Written out for three states (the last one 0 where `order` is 2): small arrays would cost thirty times as much.
    """
    r, order = model.noise**2, model.order
    wide = 1e6 * max(model.noise, 1e-12) ** 2 * 1e6
    x0, x1, x2 = next(v for v in y if v == v), 0.0, 0.0
    k0 = k1 = k2 = last_s = log_s = 0.0
    cost, last_h, settled = 0.0, -1.0, False
    added = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    before = after = (wide, 0.0, 0.0, wide, 0.0, wide if order == 3 else 0.0)
    for k, value in enumerate(y):
        seen = value == value
        h = 0.0
        if k:
            h = steps[k - 1]
            g = 0.5 * h * h
            x0 += h * x1 + g * x2
            x1 += h * x2
        if settled and seen and h == last_h:
            innovation = value - x0
        else:
            settled = False
            before = after
            if k:
                if h != last_h:
                    added = _process(h, model.q, order)
                before = _after_step(after, h, added)
            after = before
            k0 = k1 = k2 = innovation = 0.0
            if seen:
                innovation = value - x0
                (k0, k1, k2), s, after = _after_reading(before, r)
                settled = h == last_h and abs(s - last_s) <= model.settled * s
                last_s, log_s = s, log(s)
            last_h = h
        if seen:
            x0, x1, x2 = x0 + k0 * innovation, x1 + k1 * innovation, x2 + k2 * innovation
            if k > order:
                cost += innovation * innovation / last_s + log_s
        if keep is not None:
            keep.append((k0, k1, k2, *before, *after))
    return cost


def _square(upper: np.ndarray, order: int) -> np.ndarray:
    """Symmetric matrices `(time, a, a)` from their upper triangles `(time, 6)`."""
    return upper[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)[:, :order, :order]


def smoother(y: np.ndarray, dt: np.ndarray, noise: float, order: int, limits: SmootherSettings) -> Smoother:
    """Smoother for the readings of a log; the intensity of its process maximises the likelihood of the stretch that moves most.

    Args:
        y: readings (time,) [SI], NaN where one is missing.
        dt: steps between them (time - 1,) [s].
        noise: standard deviation of a reading [SI].
        order: 2 for rates, 3 for angles.
        limits: limits of the smoother.

    Returns:
        The smoother, which serves any readings at the same times.
    """
    length = min(len(y), limits.stretch)
    starts = range(0, len(y) - length + 1, max(1, length // 2))
    first = max(starts, key=lambda s: _moves(y[s : s + length]))
    steps = [round(h, 9) for h in dt.tolist()]
    part, part_steps = y[first : first + length].tolist(), steps[first : first + length - 1]
    typical = noise**2 / np.median(dt[first : first + length - 1]) ** (2 * order - 1)
    best: dict = minimize_scalar(  # pyright: ignore[reportAssignmentType]
        lambda e: _filter(part, part_steps, _Model(noise, typical * 10.0**e, order, limits.settled)),
        bounds=(-9.0, 4.0),
        method="bounded",
        options={"xatol": 0.1},
    )
    kept: list[tuple[float, ...]] = []
    intensity = float(typical * 10.0 ** float(best["x"]))
    _filter(y.tolist(), steps, _Model(noise, intensity, order, limits.settled), kept)
    table = np.array(kept)
    before, V = _square(table[:, 3:9], order), _square(table[:, 9:], order).copy()
    F = _transitions(np.array(steps), order)
    G = np.swapaxes(np.linalg.solve(before[1:], F @ V[:-1]), 1, 2)
    for k in range(len(y) - 2, -1, -1):
        V[k] += G[k] @ (V[k + 1] - before[k + 1]) @ G[k].T
    deviation = np.sqrt(np.maximum(np.diagonal(V, axis1=1, axis2=2), 0.0))
    return Smoother(F, table[:, :order], G, deviation)


def _moves(y: np.ndarray) -> float:
    """How much readings (time,) [SI] change from one to the next that there is; 0 where there are too few."""
    steps = np.diff(y[np.isfinite(y)])
    return float(np.std(steps)) if len(steps) > 1 else 0.0


def _transitions(h: np.ndarray, order: int) -> np.ndarray:
    """Transition of every step (time - 1, a, a) from the steps [s]."""
    F = np.tile(np.eye(order), (len(h), 1, 1))
    for a in range(order - 1):
        F[:, a, a + 1] = h
    if order == 3:
        F[:, 0, 2] = 0.5 * h**2
    return F
