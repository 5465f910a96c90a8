"""Long logs with fewer samples: several in a row become one, whose command is their mean and whose readings are those of the first.

Of many logs some stand for all.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax.errors import in_two_digits
from rwjax.logs.log import Log
from rwjax.logs.sheet import FEWEST


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
    most = [_most(log, wanted, coarsest) for log in logs]
    if max(most, default=1) < 2:
        return tuple(logs), ""
    found = tuple(_thinned(log, every) if every > 1 else log for log, every in zip(logs, most, strict=True))
    left, every = sum(len(log.time) for log in found), max(most)
    step = max(float(np.median(np.diff(log.time))) for log in found)
    return found, (
        f"the logs have {whole} samples, of which {left} were taken, one of every {every} of the finest: standard errors are up to "
        f"{in_two_digits(every**0.5)} times as large, and nothing faster than {2.0 * step:.3g} s is seen"
    )


def some_of(logs: Sequence[Log], samples: int, fewest: int) -> tuple[tuple[Log, ...], str]:
    """Some logs in the place of many, evenly over those to fit and over those to judge on.

    Args:
        logs: The logs.
        samples: Samples wanted at the most [1].
        fewest: Logs of either kind that stay in any case [1].

    Returns:
        The logs, and what was done as a sentence, "" for nothing. Errors of estimates grow by the root of how many times fewer they are.
    """
    whole = sum(len(log.time) for log in logs)
    kept: set[int] = set()
    for validate in (False, True):
        own = [k for k, log in enumerate(logs) if log.validate == validate]
        count = min(max(len(own) * samples // max(whole, 1), fewest), len(own))
        kept |= {own[round(at)] for at in np.linspace(0, len(own) - 1, count)}
    if whole <= samples or len(kept) == len(logs):
        return tuple(logs), ""
    return tuple(logs[k] for k in sorted(kept)), (
        f"of {len(logs)} logs {len(kept)} were taken, evenly in the given order: standard errors are about "
        f"{in_two_digits((len(logs) / len(kept)) ** 0.5)} times as large"
    )


def _most(log: Log, wanted: int, coarsest: float) -> int:
    """Of how many samples of a log one may be taken, as many as wanted at the most."""
    step = float(np.median(np.diff(log.time)))
    return min(wanted, int(coarsest / step * (1.0 + 1e-6)), len(log.time) // FEWEST)


def _thinned(log: Log, every: int) -> Log:
    """A log with every n-th reading of each output, and the mean command from each of these samples to the next."""
    read = (np.flatnonzero(np.isfinite(y))[::every] for y in log.outputs.values())
    first = np.unique(np.concatenate([[0], *read]).astype(int))
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
