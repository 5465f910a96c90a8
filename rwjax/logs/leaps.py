"""Leaps: an angle that goes on from another place between two samples, as after a counter was set anew.

No model is asked. A body with inertia goes from sample to sample hardly farther than it does elsewhere in the log. A leap is at least ten times as
large as every other change, if the rig is seen to move in many others, and stands alone. So none is

* a quick step of a rig that rests, or is sampled too slowly to see it move;
* what a servo does right after its goal jumps;
* what a sensor catches up after it hung at one reading while the command changed (`rwjax.logs.dropouts.freezes`).

Logs whose samples come in bursts are not judged, since little is known of the motion between these.
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from rwjax.kinds import GOAL, is_angle
from rwjax.logs.dropouts import COMMANDED, PAUSE
from rwjax.logs.log import Log

TIMES = 10.0
"""Largest other changes from which a change is a leap; and median changes of a goal from which that jumps [1]."""
MOST = 3
"""Leaps of one log; of more a model has to tell."""
MANY, NEARLY, IN_A_ROW = 20, 0.25, 3
"""Other changes by which the rig is seen to move; the share of the largest of them that each has at least; how many of them in a row go one way,
which noise seldom does [1]."""
ANSWER = 15
"""Samples after a jump of the goal in which a servo may go its way."""


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
    seen = np.flatnonzero(np.isfinite(log.outputs[name]))
    y, time = log.outputs[name][seen], log.time[seen]
    new = np.flatnonzero(np.diff(y, prepend=np.nan) != 0.0)  # readings that differ from the one before
    if not is_angle(name) or len(new) <= MANY + MOST:
        return []
    way, waited = np.diff(y[new]), np.diff(new)
    step = np.diff(time)[new[1:] - 1]
    way_in_time = way / np.where(_commanded(log, seen[new]), waited, 1)
    change = np.where(step <= PAUSE * np.median(np.diff(time)), np.abs(way_in_time), 0.0)
    largest = np.argsort(change)[::-1]
    if _moving(np.delete(way_in_time, largest[:MOST]), NEARLY * float(change[largest[MOST]])) < MANY:
        return []
    for many in range(MOST, 0, -1):
        found = np.sort(largest[:many])
        if change[found].min() > TIMES * change[largest[many]] and np.all(np.diff(found) > 1):
            alone = [k for k in found if not _asked_for(log, int(seen[new[k + 1]]))]
            return [Leap(name, float(time[new[k + 1]]), float(y[new[k]]), float(y[new[k + 1]])) for k in alone]
    return []


def _commanded(log: Log, new: np.ndarray) -> np.ndarray:
    """Whether the command changes from each sample of some to the next of these."""
    given = log.command.reshape(len(log.time), -1)
    changes = np.maximum.reduceat(given, new) - np.minimum.reduceat(given, new)
    return np.any(changes > COMMANDED * np.ptp(given, axis=0), axis=1)[:-1]


def _asked_for(log: Log, sample: int) -> bool:
    """Whether a goal has jumped right before a sample."""
    if log.input != GOAL:
        return False
    jumps = np.abs(np.diff(log.command))
    return bool(np.any(jumps[max(sample - ANSWER, 0) : sample] > TIMES * np.median(jumps)))


def _moving(way: np.ndarray, least: float) -> int:
    """How many rows of changes go one way, each of them larger than a size."""
    rows = sliding_window_view(way, IN_A_ROW)
    return int(np.sum((rows.min(axis=1) > least) | (rows.max(axis=1) < -least)))
