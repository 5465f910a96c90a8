"""Power spectra of records, by Welch's method, and their power in octaves beyond that of noise."""

from collections.abc import Sequence
from typing import NamedTuple

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


class OctavePower(NamedTuple):
    """Power of several records and of draws of their noise, by octave.

    Attributes:
        edges: edges of the octaves (o + 1,) [Hz], the first one 0.
        power: energy of the records (column 0) and of each draw (o, 1 + draws) [unit² s].
        duration: length of the records that tell an octave (o,) [s].
    """

    edges: np.ndarray
    power: np.ndarray
    duration: np.ndarray

    @property
    def expected(self) -> np.ndarray:
        """Energy of the noise (o,) [unit² s]."""
        return np.mean(self.power[:, 1:], axis=1)

    @property
    def beyond(self) -> np.ndarray:
        """Energy of the records beyond that of the noise (o,) [unit² s]."""
        return np.maximum(self.power[:, 0] - self.expected, 0.0)


def octave_power(
    records: Sequence[np.ndarray], own: Sequence[np.ndarray], interval: Sequence[float], window: int
) -> OctavePower:
    """Power of records and of draws of their noise, by octave.

    An octave is told by the records that are long enough for its upper edge and sampled fast enough for it.

    Args:
        records: records (time,) [any unit].
        own: draws of the noise of each record (time, draws) [the same unit].
        interval: sampling interval of each record [s].
        window: samples of a Welch window.

    Returns:
        The power, the lowest octave first.
    """
    lowest = 1.0 / max(len(y) * h for y, h in zip(records, interval, strict=True))
    highest = 0.5 / min(interval)
    count = max(int(np.log2(highest / lowest)), 1)
    edges = highest * 2.0 ** -np.arange(count, -1.0, -1.0)
    edges[0] = 0.0
    power, duration = np.zeros((count, 1 + own[0].shape[1])), np.zeros(count)
    for y, o, h in zip(records, own, interval, strict=True):
        both, lasts = np.concatenate([y[:, None], o], axis=1), len(y) * h
        fine = 8.0 / (min(window, len(y)) * h)
        spectra = [welch(both, h, length) for length in (len(y), min(window, len(y)))]
        for k, (low, high) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
            if 1.0 / lasts < high < 0.5 / h * (1.0 + 1e-6):
                f, density = spectra[0 if high <= fine else 1]  # low octaves need the whole record
                power[k] += np.sum(density[(f >= low) & (f < high)], axis=0) * f[1] * lasts
                duration[k] += lasts
    return OctavePower(edges, power, duration)
