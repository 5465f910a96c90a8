"""Long logs with fewer samples: several in a row become one, whose command is their mean and whose readings are those of the first."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax.logs.log import Log


def thinned(logs: Sequence[Log], samples: int, coarsest: float) -> tuple[tuple[Log, ...], str]:
    """Logs that together have no more samples than wanted, as far as that leaves a step fine enough.

    Args:
        logs: The logs.
        samples: Samples wanted at the most [1].
        coarsest: Longest step between samples that is made [s].

    Returns:
        The logs, and what was done as a sentence, "" for nothing. Every n-th reading stays, so that errors of estimates grow by the root
        of n where readings are independent; what is faster than two steps is seen no more.
    """
    whole = sum(len(log.time) for log in logs)
    wanted = -(-whole // samples)
    step = min(float(np.median(np.diff(log.time))) for log in logs if len(log.time) > 1)
    every = min(wanted, int(coarsest / step * (1.0 + 1e-6)))
    if every < 2:
        return tuple(logs), ""
    found = tuple(_thinned(log, every) for log in logs)
    left = sum(len(log.time) for log in found)
    return found, (
        f"the logs have {whole} samples, of which every {every}th was taken ({left}): standard errors are up to {every**0.5:.2g} times as "
        f"large, and nothing faster than {2.0 * every * step:.3g} s is seen"
    )


def _thinned(log: Log, every: int) -> Log:
    """A log with every n-th reading, and the mean command from each to the next."""
    first = np.arange(0, len(log.time), every)
    held = np.diff(log.time, append=2.0 * log.time[-1] - log.time[-2])  # how long each command is held

    def mean(values: np.ndarray) -> np.ndarray:
        weight = held if values.ndim == 1 else held[:, None]
        total = np.add.reduceat(held, first)
        return np.add.reduceat(values * weight, first, axis=0) / (total if values.ndim == 1 else total[:, None])

    return replace(
        log,
        time=log.time[first],
        command=mean(log.command),
        outputs={name: y[first] for name, y in log.outputs.items()},
        supply=None if log.supply is None else mean(log.supply),
        enabled=None if log.enabled is None else log.enabled[first],
        acting=None if log.acting is None else mean(log.acting),
    )
