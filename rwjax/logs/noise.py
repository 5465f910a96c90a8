"""Noise of each logged output: what even a perfect model leaves, read from the fastest part of the signal."""

from math import comb

import numpy as np

from rwjax.logs.log import Log

KEPT, OF_KEPT = 0.8, 0.6616
"""Share of the smallest differences that is used, and the root mean square of that share of a standard normal."""
JITTER = 2.0
"""Noise of a counted reading, in units of its rounding error, below which it is the rounding alone."""
PLAINLY = 0.85  # less than this share of the estimate so far: more than chance
ORDERS = (3, 5, 7)  # of the differences; what moves smoothly shrinks with the order, white noise does not
SMOOTH = 25  # samples, over which a turning angle is smoothed
TURNS = 4.0  # from which on an error that repeats with the turn is told from noise


def quantisation(log: Log, output: str) -> float:
    """Standard deviation [SI] of rounding to counts, $q/\\sqrt{12}$; 0 where the reading is not in counts."""
    return log.resolution.get(output, 0.0) / np.sqrt(12.0)


def rapid(signal: np.ndarray, turning: bool = False) -> float:
    """Size of what changes from sample to sample without pattern: differences, robust against steps, of a higher
    order where that is plainly less: a motion that is sampled slowly stays in the low orders. Of an angle that is
    `turning`, what repeats with the turn is a pattern, too: an encoder's eccentricity, however fast."""
    signal = signal[np.isfinite(signal)]
    sizes = [_size(d) for d in _differences(signal)]
    if turning and len(signal) > SMOOTH and np.ptp(signal) > TURNS * 2.0 * np.pi:
        from scipy.signal import savgol_filter  # half a second, which only angles that turn are worth

        # the readings themselves would bring their noise with them
        angle = np.asarray(savgol_filter(signal, SMOOTH, 3))
        turn = np.array([f(k * angle) for k in (1, 2) for f in (np.sin, np.cos)]).T
        for d, repeats in zip(_differences(signal), _differences(turn), strict=True):
            sizes.append(_size(d - repeats @ np.linalg.lstsq(repeats, d, rcond=None)[0]))
    lowest = sizes[0] if sizes else 0.0
    for sigma in sizes[1:]:
        lowest = sigma if sigma < PLAINLY * lowest else lowest
    return lowest


def _differences(signal: np.ndarray) -> list[np.ndarray]:
    """Differences of `ORDERS` along time, which leave the size of white noise as it is; no fewer than 8."""
    every = (np.diff(signal, n=order, axis=0) / np.sqrt(comb(2 * order, order)) for order in ORDERS)
    return [d for d in every if len(d) >= 8]


def _size(d: np.ndarray) -> float:
    """Standard deviation that differences would have without their largest ones."""
    size = np.sort(np.abs(d))
    robust = np.sqrt(np.mean(size[: int(KEPT * len(d))] ** 2)) / OF_KEPT
    # printed or counted readings may repeat so often that this is 0: then all but the largest 2 %
    return float(robust if robust > 0.0 else np.sqrt(np.mean(size[: max(8, int(0.98 * len(d)))] ** 2)))


def of_readings(log: Log) -> dict[str, float]:
    """Standard deviation [SI] of each output's noise, from the log alone; never below quantisation."""
    found = {}
    for name, value in log.outputs.items():
        seen = value[np.isfinite(value)]
        step = quantisation(log, name)
        sigma = rapid(value, turning=name.endswith("_rad"))
        if sigma < JITTER * step:
            sigma = step
        tiny = 1e-9 * float(np.max(np.abs(seen), initial=0.0)) + 1e-12
        found[name] = max(sigma, tiny)
    return found


def pooled(logs: "tuple[Log, ...]") -> dict[str, float]:
    """One standard deviation for each output over all logs (root of the mean variance)."""
    each = [of_readings(log) for log in logs]
    names = {name for noise in each for name in noise}
    return {name: float(np.sqrt(np.mean([noise[name] ** 2 for noise in each if name in noise]))) for name in names}
