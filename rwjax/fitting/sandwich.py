"""The middle of the sandwich covariance for correlated residuals, and the directions that a normal matrix leaves open."""

import numpy as np

UNIDENTIFIED = 1e-8
"""Ratio of the smallest to the largest eigenvalue of the normalised normal equations below which a combination of
numbers is called undetermined [1]."""
WEIGHS = 0.01
"""Weight in an undetermined combination above which a number is undetermined itself [1]."""


def _bandwidth(series: np.ndarray) -> float:
    """Bartlett bandwidth in samples by the first-order plug-in of Andrews (Econometrica 59, 1991, eq. 6.4)."""
    num = den = 0.0
    series = series / max(
        float(np.max(np.abs(series), initial=0.0)), 1e-300
    )  # no power of it leaves the range of numbers
    for x in series.T:
        x = x - x.mean()
        power = float(x @ x)
        if power <= 0.0:
            continue
        rho = min(max(float(x[1:] @ x[:-1]) / power, 0.0), 0.999)
        innovation = (1.0 - rho**2) * power / len(x)
        num += 4.0 * rho**2 * innovation**2 / ((1.0 - rho) ** 6 * (1.0 + rho) ** 2)
        den += innovation**2 / (1.0 - rho) ** 4
    return 1.1447 * (num / den * len(series)) ** (1.0 / 3.0) if den > 0.0 else 0.0


def meat(jacobians: list[np.ndarray], residuals: list[np.ndarray]) -> np.ndarray:
    """Long-run covariance of the score, summed over logs.

    Args:
        jacobians: For each log the derivative of its residual `(time, output, k)` [1].
        residuals: For each log its residual in units of noise `(time, output)` [1].

    Returns:
        Covariance `(k, k)` [1].

    Source:
        Newey and West, Econometrica 55 (1987).
    """
    k = jacobians[0].shape[-1]
    total = np.zeros((k, k))
    for G, r in zip(jacobians, residuals, strict=True):
        score = np.einsum("tya,ty->ta", G, r)
        width = min(_bandwidth(score), len(score) / 4.0)
        lags = np.arange(min(int(np.ceil(width)) + 1, len(score)))  # all of positive weight: no variance is below 0
        size = 1
        while size < len(score) + len(lags):
            size *= 2
        weight = np.zeros((size, 1))
        weight[lags, 0] = weight[-lags, 0] = 1.0 - lags / (width + 1.0)
        spectrum = np.fft.rfft(score, size, axis=0) * np.fft.rfft(weight, axis=0)
        total += score.T @ np.fft.irfft(spectrum, size, axis=0)[: len(score)]
    return total


def undetermined(A: np.ndarray) -> np.ndarray:
    """Which numbers have a share in a combination that a normal matrix leaves undetermined.

    Args:
        A: Normal matrix `(k, k)` [1].

    Returns:
        True for these `(k,)` [true or false].
    """
    d = np.sqrt(np.maximum(np.diag(A), 1e-300))
    values, vectors = np.linalg.eigh(A / d / d[:, None])
    return (np.abs(vectors[:, values < UNIDENTIFIED * values[-1]]) > WEIGHS).any(axis=1) | (np.diag(A) <= 0.0)
