"""Worst windows: the seconds in which the gap arises.

A free run that was once led astray stays away from its log, so that its error is large long after its cause. The missing torque is large
where it acts. So the windows are the seconds with most missing torque, and those with most error only where no missing torque is told.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.gap import HeldOut
from rwjax.diagnosis.localise.regimes import weights
from rwjax.diagnosis.localise.where import Missing
from rwjax.logs.log import Log


class Window(NamedTuple):
    """One second of a log: the log's name, its begin and end [s], and its share of the missing torque's square or of the error's [1]."""

    log: str
    begin: float
    end: float
    share: float


def worst_windows(
    missing: Sequence[Missing], error: HeldOut, logs: Sequence[Log], signal: str, most: int
) -> tuple[Window, ...]:
    """Seconds in which the gap arises.

    Args:
        missing: missing torque of logs, of some or none.
        error: errors on the held-out logs.
        logs: all logs.
        signal: the output to look at where there is no missing torque.
        most: how many windows.

    Returns:
        At most so many windows with a share, the worst one first.
    """
    if missing:
        return _shared_out({m.log: _mass(m) for m in missing}, logs, most)
    square = {k: np.nan_to_num(e[signal]) ** 2 for k, e in error.error.items() if signal in e}
    return _shared_out(square, logs, most)


def _mass(missing: Missing) -> np.ndarray:
    """Square of the missing torque in units of its standard deviation (time,) [1], beyond what the rig's own noise would show."""
    weight = weights(missing.deviation)
    own = np.mean(missing.own**2, axis=1) if missing.own.shape[1] else missing.deviation**2
    return np.nan_to_num(weight * (missing.torque**2 - own))


def _shared_out(mass: dict[int, np.ndarray], logs: Sequence[Log], most: int) -> tuple[Window, ...]:
    """The seconds that hold most of a mass (time,) by log."""
    by_second = {}
    for k, values in mass.items():
        t = logs[k].time
        by_second[k] = np.maximum(np.bincount(np.floor(t - t[0]).astype(int), weights=values), 0.0)
    total = sum(float(np.sum(of)) for of in by_second.values())
    if total == 0.0:
        return ()
    found = []
    for k, of in by_second.items():
        t = logs[k].time
        for s in np.argsort(-of, kind="stable")[: min(most, np.count_nonzero(of))]:
            found.append(Window(logs[k].name, float(t[0] + s), float(min(t[0] + s + 1.0, t[-1])), float(of[s] / total)))
    return tuple(sorted(found, key=lambda w: -w.share)[:most])
