"""Worst windows: the seconds of the held-out logs in which the error of the rig as it is arises."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.gap import HeldOut
from rwjax.logs.log import Log


class Window(NamedTuple):
    """One second of a log: the log's name, its begin and end [s], and its share of the squared error [1]."""

    log: str
    begin: float
    end: float
    share: float


def worst_windows(before: HeldOut, logs: Sequence[Log], signal: str, most: int) -> tuple[Window, ...]:
    """Seconds of the held-out logs that hold the most squared error.

    Args:
        before: errors of the rig as it is.
        logs: all logs.
        signal: the output to look at.
        most: how many windows.

    Returns:
        At most so many windows, the worst one first; none where there is no error.
    """
    total = float(np.sum(before.square[signal]))
    found: list[Window] = []
    if total == 0.0:
        return ()
    for k, by_output in before.error.items():
        if signal not in by_output:
            continue
        t = logs[k].time
        second = np.floor(t - t[0]).astype(int)
        square = np.nan_to_num(by_output[signal]) ** 2
        mass = np.bincount(second, weights=square) / total
        for s in np.argsort(-mass)[:most]:
            found.append(Window(logs[k].name, float(t[0] + s), float(min(t[0] + s + 1.0, t[-1])), float(mass[s])))
    return tuple(sorted(found, key=lambda w: -w.share)[:most])
