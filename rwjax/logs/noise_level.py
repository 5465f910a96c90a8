"""Noise of a signal, estimated from its readings alone.

The estimate is the size of the signal's differences: a smooth motion hardly has any, white noise keeps its own.
"""

from math import comb

import numpy as np

KEPT_SHARE, KEPT_RMS = 0.8, 0.6616
"""Share of the smallest differences that is used, and the root mean square of that share of a standard normal."""
LOWER = 0.85
"""Ratio to the estimate so far below which a lower one is taken: more than chance."""
ORDERS = (3, 5, 7)
"""Orders of the differences: what moves smoothly shrinks with the order, white noise does not."""
FEWEST_DIFFERENCES = 8
SMOOTHED = 25
"""Samples over which a turning angle is smoothed."""
TURNS = 4.0
"""Turns from which on an error that repeats with the turn is told from noise."""


def noise_level(signal: np.ndarray, turning: bool = False) -> float:
    """Standard deviation of what changes from sample to sample without pattern.

    It comes from the signal's differences without the largest fifth, so that steps do not count. A higher order of
    the differences is taken where it gives clearly less: a motion that is sampled slowly stays in the low orders.

    Args:
        signal: Readings (n,) [any unit]; what is not finite is left out.
        turning: Whether the readings are an angle [rad]. What repeats with the turn then is no noise either, such
            as the error of an encoder mounted off centre.

    Returns:
        The standard deviation [as the signal]; 0 for a signal too short.
    """
    signal = signal[np.isfinite(signal)]
    sizes = [_size(d) for d in _differences(signal)]
    if turning and len(signal) > SMOOTHED and np.ptp(signal) > TURNS * 2.0 * np.pi:
        from scipy.signal import savgol_filter  # takes half a second to import, and only angles that turn need it

        # smoothed, since the noise of the readings themselves would fit itself
        angle = np.asarray(savgol_filter(signal, SMOOTHED, 3))
        turn = np.array([f(k * angle) for k in (1, 2) for f in (np.sin, np.cos)]).T
        for d, repeats in zip(_differences(signal), _differences(turn), strict=True):
            sizes.append(_size(d - repeats @ np.linalg.lstsq(repeats, d, rcond=None)[0]))
    lowest = sizes[0] if sizes else 0.0
    for sigma in sizes[1:]:
        lowest = sigma if sigma < LOWER * lowest else lowest
    return lowest


def _differences(signal: np.ndarray) -> list[np.ndarray]:
    """Differences of `ORDERS` along time, scaled so that white noise keeps its size; none that are too few."""
    every = (np.diff(signal, n=order, axis=0) / np.sqrt(comb(2 * order, order)) for order in ORDERS)
    return [d for d in every if len(d) >= FEWEST_DIFFERENCES]


def _size(d: np.ndarray) -> float:
    """Standard deviation of normal differences, from all but the largest ones."""
    size = np.sort(np.abs(d))
    robust = np.sqrt(np.mean(size[: int(KEPT_SHARE * len(d))] ** 2)) / KEPT_RMS
    # printed or counted readings may repeat so often that this is 0: then all but the largest 2 %
    return float(robust if robust > 0.0 else np.sqrt(np.mean(size[: max(FEWEST_DIFFERENCES, int(0.98 * len(d)))] ** 2)))
