"""Questions about angles in degrees where the motion goes with the angle itself, as that of a joint that hangs.

A free run from a first angle that is 57 times too large is like no reading, so that its size against the readings says nothing.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from rwjax.fitting.questions.likeness import GIVEN, Question, Run, explained, names_of, plainly_better
from rwjax.kinds import is_angle
from rwjax.logs.log import Log

NOTHING = 0.1
"""Share explained by angles as rad from which none is asked about: a motion that is 57 times too large is like nothing simulated [1]."""

WIDE = 0.5
"""Swing from which the sine of an angle is told from the angle [rad]."""


def about_degrees(runs: Sequence[Run], in_rad: Callable[[], Sequence[Run]]) -> list[Question]:
    """A question about angles that were read as rad, where the logs are like their free runs once they are taken for degrees.

    Args:
        runs: Logs with their free runs.
        in_rad: The same logs, their angles taken for degrees, with the free runs that begin there.

    Returns:
        The question; none where some log is like its free run as it is, or less so as degrees.
    """
    shares = [explained(run) for run in runs]
    names = dict.fromkeys(name for run in runs for name in angles_of(run.log))
    if not names or max(shares) >= NOTHING:
        return []
    others = in_rad()
    asked = [
        run.log
        for run, share, other in zip(runs, shares, others, strict=True)
        if plainly_better(share, explained(other))
    ]
    if not asked or any(explained(other) < share for share, other in zip(shares, others, strict=True)):
        return []
    return [
        Question(
            f"{names_of(asked)}: {' and '.join(names)} taken for degrees is like {GIVEN}, and as it is not: are the readings in degrees? "
            'Write unit = "deg" in [columns], or divide them by 57.296'
        )
    ]


def angles_of(log: Log) -> list[str]:
    """The angles of a log that were no counts.

    Args:
        log: The log.

    Returns:
        Names of its outputs.
    """
    return [name for name in log.outputs if is_angle(name) and not log.resolution.get(name)]


def from_degrees(log: Log) -> Log:
    """A log whose angles are taken for degrees.

    Args:
        log: The log.

    Returns:
        The same, its angles in rad; the log itself where it holds none.
    """
    angles = angles_of(log)
    return (
        replace(log, outputs=log.outputs | {name: np.radians(log.outputs[name]) for name in angles}) if angles else log
    )


def from_wide_degrees(log: Log) -> Log:
    """A log whose angles are taken for degrees, where they swing widely as such: of a small swing a weight pulls as a spring does, in any unit.

    Args:
        log: The log.

    Returns:
        The same, its angles in rad; the log itself where none of them swings by `WIDE`.
    """
    other = from_degrees(log)
    swings = [other.outputs[name][np.isfinite(other.outputs[name])] for name in angles_of(log)]
    return other if any(y.size and np.ptp(y) > WIDE for y in swings) else log
