"""Noise of each logged output, estimated from the readings alone: what even a perfect model leaves."""

import numpy as np

from rwjax.logs.log import Log
from rwjax.logs.noise_level import noise_level

ROUNDING_ALONE = 2.0
"""Noise of a counted reading, in units of its rounding error, below which it is the rounding alone."""


def quantisation(log: Log, output: str) -> float:
    r"""Standard deviation [SI] of rounding to counts of size $q$, $q/\sqrt{12}$.

    Args:
        log: Any log.
        output: Name of one of its outputs.

    Returns:
        The standard deviation; 0 where the reading is not in counts.
    """
    return log.resolution.get(output, 0.0) / np.sqrt(12.0)


def noise_by_output(log: Log) -> dict[str, float]:
    """Standard deviation of the noise of each output, from one log alone.

    Args:
        log: Any log.

    Returns:
        Standard deviation [SI] by output, never below `quantisation`.
    """
    found = {}
    for name, value in log.outputs.items():
        seen = value[np.isfinite(value)]
        step = quantisation(log, name)
        sigma = noise_level(value, turning=name.endswith("_rad"))
        if sigma < ROUNDING_ALONE * step:
            sigma = step
        tiny = 1e-9 * float(np.max(np.abs(seen), initial=0.0)) + 1e-12
        found[name] = max(sigma, tiny)
    return found


def pooled_noise(logs: tuple[Log, ...]) -> dict[str, float]:
    """Standard deviation of the noise of each output over several logs: the root of the mean variance.

    Args:
        logs: Logs of one rig.

    Returns:
        Standard deviation [SI] by output, of every output that any log holds.
    """
    each = [noise_by_output(log) for log in logs]
    names = dict.fromkeys(name for noise in each for name in noise)  # a set has another order in every process
    return {name: float(np.sqrt(np.mean([noise[name] ** 2 for noise in each if name in noise]))) for name in names}
