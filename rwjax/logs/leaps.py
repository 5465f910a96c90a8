"""Leaps: an angle that goes on from another place between two samples, as after a counter was set anew.

No model is asked. A body with inertia goes from sample to sample hardly farther than it does elsewhere in the log. A leap is at least ten times as
large as every other change, if the rig is seen to move in many others. So a quick step of a rig that rests, or is sampled too slowly to see it move, is
none. Nor is what a sensor catches up after it hung at one reading (`rwjax.logs.dropouts.freezes`).
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from rwjax.kinds import is_angle
from rwjax.logs.log import Log

TIMES = 10.0
"""Largest other changes from which a change is a leap [1]."""
MOST = 3
"""Leaps of one log; of more a model has to tell."""
MANY, NEARLY, IN_A_ROW = 20, 0.25, 3
"""Other changes by which the rig is seen to move; the share of the largest of them that each has at least; how many of them in a row go one way,
which noise seldom does [1]."""
PAUSE = 5.0
"""Time between two readings over the median one, from which nothing is known of the motion between them [1]."""


class Leap(NamedTuple):
    """A leap of an angle.

    Attributes:
        output: Name of the angle.
        at: Time of the first reading behind it [s].
        before: The reading before it [rad].
        after: The reading behind it [rad].
    """

    output: str
    at: float
    before: float
    after: float

    @property
    def says(self) -> str:
        """What it is and what to do, one sentence."""
        return (
            f"{self.output} leaps from {self.before:.4g} to {self.after:.4g} rad at {self.at:.6g} s and goes on from there: was the "
            "counter set anew? Take the difference off all readings behind it, or split the log there"
        )


def leaps(log: Log, name: str) -> list[Leap]:
    """The leaps of one output of a log.

    Args:
        log: The log, without outliers and drop-outs.
        name: Name of the output.

    Returns:
        The leaps in the order of time; none of an output that is no angle.
    """
    seen = np.isfinite(log.outputs[name])
    y, time = log.outputs[name][seen], log.time[seen]
    if not is_angle(name) or len(y) <= MANY + MOST:
        return []
    step, way = np.diff(time), np.diff(y)
    new = np.flatnonzero(np.concatenate([[True], way != 0.0]))  # readings that differ from the one before
    waited = np.arange(1, len(y)) - new[np.searchsorted(new, np.arange(1, len(y))) - 1]
    change = np.where(step <= PAUSE * np.median(step), np.abs(way) / waited, 0.0)
    largest = np.argsort(change)[::-1]
    for many in range(MOST, 0, -1):
        found, fastest = np.sort(largest[:many]), change[largest[many]]
        if change[found].min() > TIMES * fastest and _moving(np.delete(way, found), NEARLY * fastest) >= MANY:
            return [Leap(name, float(time[k + 1]), float(y[k]), float(y[k + 1])) for k in found]
    return []


def _moving(way: np.ndarray, least: float) -> int:
    """Changes of at least a size after which as many go the same way as a motion has in a row."""
    sizes = sliding_window_view(way, IN_A_ROW)
    return int(np.sum((sizes.min(axis=1) > least) | (sizes.max(axis=1) < -least)))
