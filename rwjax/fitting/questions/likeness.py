"""How far a measured motion follows a simulated one: the numbers from which questions are asked."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from rwjax.fitting.initial_guess import START_S
from rwjax.kinds import is_angle
from rwjax.logs.log import Log

ALIKE = 0.8
"""Correlation of measured and simulated motion from which one follows the other [1]."""
AS_IT_IS = 0.7
"""Share explained by a log as it is, from which it is not asked about in another unit [1]."""
LEFT = 0.2
"""Share of the motion's square that another unit may leave [1]."""
LEAVES = 0.25
"""Share of what the log as it is leaves that another unit may leave [1]."""
SHARE = 0.5
"""Share of a short run within which the change of an angle is taken [1]."""
GIVEN = "what the rig file's numbers give"


class Question(str):
    """A note that asks whether a log is what its columns say."""


def names_of(logs: Sequence[Log]) -> str:
    """Logs in words, for a question about several.

    Args:
        logs: The logs, at least one.

    Returns:
        The name of the first, and how many more there are.
    """
    first, *rest = [log.name for log in logs]
    return first if not rest else f"{first} and {rest[0]}" if len(rest) == 1 else f"{first} and {len(rest)} more"


class Run(NamedTuple):
    """A log beside its free run with the rig file's numbers.

    Attributes:
        log: The log.
        simulated: Simulated readings `(time,)` [SI] by output.
    """

    log: Log
    simulated: Mapping[str, np.ndarray]


class Likeness(NamedTuple):
    """Measured against simulated motion of one output.

    Attributes:
        correlation: Their correlation about zero [1].
        times: How many times the simulated motion the measured one is [1].
        explained: Share of the measured motion's square that the simulated one removes, negative where it adds [1].
    """

    correlation: float
    times: float
    explained: float


def motion(log: Log, name: str, values: np.ndarray) -> np.ndarray:
    """What moves in a reading.

    Args:
        log: The log, with its times.
        name: Name of the output.
        values: Its readings `(…, time)`, measured or simulated [SI].

    Returns:
        A rate as it is; of an angle its change within 0.5 s, or within half of a run that lasts less than 1 s, since a free axis
        drifts `(…, m)` [SI].
    """
    if not is_angle(name):
        return values
    apart = min(START_S, SHARE * float(np.ptp(log.time)))  # a run in the wrong time may last a few ms
    later = np.searchsorted(log.time, log.time + apart)
    later = later[: np.searchsorted(later, len(log.time))]
    with np.errstate(invalid="ignore"):  # a run that has failed is infinite
        return values[..., later] - values[..., : len(later)]


def likeness(run: Run, name: str) -> Likeness:
    """How far an output follows its simulation.

    Args:
        run: A log with its free run.
        name: Name of the output, which the log holds.

    Returns:
        The likeness; 0 throughout where either of the two does not move.
    """
    both = motion(run.log, name, np.stack([run.log.outputs[name], run.simulated[name]]))
    a, b = both[:, np.isfinite(both).all(axis=0)]
    with np.errstate(over="ignore", invalid="ignore"):  # a simulation in the wrong time or unit may grow without end
        own, given, shared = float(a @ a), float(b @ b), float(a @ b)
    if not own or not given or not np.isfinite(given):
        return Likeness(0.0, 0.0, 0.0)
    return Likeness(shared / np.sqrt(own * given), shared / given, 1.0 - float((a - b) @ (a - b)) / own)


def explained(run: Run) -> float:
    """Share of the measured motion's square that a free run removes, the mean over the outputs, -1 at least.

    Args:
        run: A log with its free run.

    Returns:
        The share [1], 1 where the two are equal.
    """
    return float(np.mean([max(likeness(run, name).explained, -1.0) for name in run.log.outputs]))


def plainly_better(share: float, other: float) -> bool:
    """Whether a log in another unit is like its free run, and as it is was not.

    Args:
        share: Share of the motion that the free run explains where the log is as it is [1].
        other: The same of the log in the other unit [1].

    Returns:
        True where little is left, against the motion and against what was left.
    """
    return share < AS_IT_IS and 1.0 - other < min(LEFT, LEAVES * (1.0 - share))
