"""Noise of each logged output: what even a perfect model leaves, read from the fastest part of the signal."""

import numpy as np

from rwjax.log import Log

MAD_TO_SIGMA = 1.0 / 0.6745  # of a normal distribution
THIRD_DIFFERENCE = np.sqrt(20.0)  # standard deviation of a third difference of white noise of unit size


def quantisation(log: Log, output: str) -> float:
    """Standard deviation [SI] of rounding to counts, $q/\\sqrt{12}$; 0 where the reading is not in counts."""
    return log.resolution.get(output, 0.0) / np.sqrt(12.0)


def rapid(signal: np.ndarray) -> float:
    """Size of what changes from sample to sample without pattern: third differences, robust against steps."""
    d = np.diff(signal[np.isfinite(signal)], n=3)
    if len(d) < 8:
        return 0.0
    robust = MAD_TO_SIGMA * np.median(np.abs(d - np.median(d))) / THIRD_DIFFERENCE
    # printed or counted readings may repeat so often that the median is 0: then the mean square, its largest 2 % left out
    kept = np.sort(np.abs(d))[: max(8, int(0.98 * len(d)))]
    return float(robust if robust > 0.0 else np.sqrt(np.mean(kept**2)) / THIRD_DIFFERENCE)


def of_readings(log: Log) -> dict[str, float]:
    """Standard deviation [SI] of each output's noise, from the log alone; never below quantisation."""
    found = {}
    for name, value in log.outputs.items():
        seen = value[np.isfinite(value)]
        sigma = quantisation(log, name)
        if sigma == 0.0:
            sigma = rapid(value)
        tiny = 1e-9 * float(np.max(np.abs(seen), initial=0.0)) + 1e-12
        found[name] = max(sigma, tiny)
    return found


def pooled(logs: tuple[Log, ...]) -> dict[str, float]:
    """One standard deviation for each output over all logs (root of the mean variance)."""
    each = [of_readings(log) for log in logs]
    names = {name for noise in each for name in noise}
    return {name: float(np.sqrt(np.mean([noise[name] ** 2 for noise in each if name in noise]))) for name in names}
