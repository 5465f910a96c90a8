"""The smoother against the penalised least-squares problem that it solves."""

import numpy as np

from rwjax.diagnosis.localise.smoother import smoother
from rwjax.diagnosis.settings import SmootherSettings


def test_the_smoother_is_the_penalised_least_squares_line() -> None:
    # order 2, uniform steps: the smoothed value minimises sum (y - x)^2/r + w' Q^-1 w, here solved as one linear system
    n, h, r = 120, 0.02, 0.05
    y = np.sin(np.arange(n) * h * 3.0) + r * np.random.default_rng(0).normal(size=n)
    y[40:43] = np.nan
    s = smoother(y, np.full(n - 1, h), r, 2, SmootherSettings())
    X = s(y)
    assert np.allclose(s(np.stack([y, 2.0 * y], axis=1))[..., 1], 2.0 * X, rtol=1e-9, atol=1e-12)
    grown = s.ahead[0]
    V_ratio = s.gain[-1, 1] / s.gain[-1, 0]  # settled gain: q from the Riccati equation's fixed point
    s0 = r**2 / (1.0 - s.gain[-1, 0])
    P = np.array([[s.gain[-1, 0] * s0, s.gain[-1, 1] * s0], [s.gain[-1, 1] * s0, np.nan]])
    q = (P[0, 1] ** 2 / s0) / h  # P11 grows by q h and loses P01^2 / s in every step
    Q = q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]])
    A, b = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
    for k in range(n):
        if np.isfinite(y[k]):
            A[2 * k, 2 * k] += 1.0 / r**2
            b[2 * k] += y[k] / r**2
        if k:
            step = np.zeros((2, 2 * n))
            step[:, 2 * k : 2 * k + 2], step[:, 2 * k - 2 : 2 * k] = np.eye(2), -grown
            A += step.T @ np.linalg.solve(Q, step)
    assert V_ratio > 0.0
    inside = slice(5, n - 5)  # the filter begins from a wide guess, not from none
    assert np.allclose(X[inside, 0], np.linalg.solve(A, b)[::2][inside], atol=2e-4 * r)
    assert np.allclose(s.deviation[inside, 0], np.sqrt(np.diag(np.linalg.inv(A))[::2][inside]), rtol=1e-3)


def test_an_angle_s_smoother_follows_a_parabola_and_a_gap_widens_its_deviation() -> None:
    n, h, noise = 400, 0.01, 1e-3
    t = np.arange(n) * h
    y = 0.5 * 3.0 * t**2 + noise * np.random.default_rng(0).normal(size=n)
    y[200:230] = np.nan
    s = smoother(y, np.full(n - 1, h), noise, 3, SmootherSettings())
    X = s(y)
    inside = slice(50, -50)
    for order, exact in enumerate((1.5 * t**2, 3.0 * t, np.full(n, 3.0))):
        assert np.all(np.abs(X[inside, order] - exact[inside]) < 5.0 * s.deviation[inside, order])
    assert s.deviation[215, 0] > s.deviation[150, 0] and np.all(s.gain[200:230] == 0.0)


def test_readings_that_begin_late_are_smoothed_by_the_stretch_that_moves() -> None:
    n, h, noise = 3500, 0.01, 1e-3
    t = np.arange(n) * h
    y = np.where(t > 16.0, np.sin(t), np.nan) + noise * np.random.default_rng(0).normal(size=n)
    s = smoother(y, np.full(n - 1, h), noise, 3, SmootherSettings())
    assert np.max(np.abs(s(y)[1700:-50, 1] - np.cos(t)[1700:-50])) < 0.05
    every_other = np.where(np.arange(n) % 2 == 0, np.sin(t), np.nan)
    assert np.all(np.isfinite(smoother(every_other, np.full(n - 1, h), noise, 3, SmootherSettings()).deviation))
