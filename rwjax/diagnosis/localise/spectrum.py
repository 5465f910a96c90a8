"""Power spectra of records, by Welch's method."""

import numpy as np
from jaxtyping import Float


def welch(
    y: Float[np.ndarray, "time k"], interval: float, length: int
) -> tuple[Float[np.ndarray, " f"], Float[np.ndarray, "f k"]]:
    """One-sided power spectral density, of means over Hann windows that overlap by half; no trend is taken off.

    It is that of `scipy.signal.welch`, whose import takes longer than the fit of a rig.

    Args:
        y: Records `(time, k)` [any unit].
        interval: Sampling interval [s].
        length: Samples of a window, two or more [1].

    Returns:
        Frequencies `(f,)` [Hz], and densities `(f, k)` [unit²/Hz].

    Source:
        Welch (1967), The use of fast Fourier transform for the estimation of power spectra.
    """
    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)
    parts = np.lib.stride_tricks.sliding_window_view(y, length, axis=0)[:: length - length // 2]
    power = np.mean(np.abs(np.fft.rfft(parts * hann)) ** 2, axis=0).T * (interval / np.sum(hann**2))
    power[1 : len(power) - (length % 2 == 0)] *= 2.0  # frequencies below 0 lie upon those above
    return np.fft.rfftfreq(length, interval), power
