"""Drop-outs: a sensor that stays at one reading while the rig moves on, as a loose plug or a hung bus makes it.

No model is asked. A body with inertia leaves no reading by a leap, so a stretch of equal readings is a drop-out where

* the readings leap to it and away from it, by more than any change between the other readings;
* what lies between the readings before and after it is a way that the rig can go in the time;
* the readings move right before and right after it: a counter that is set to 0 at rest is none.

A sensor that hangs at its last reading leaps only away. So does a servo that is sampled slowly at the end of every rest, and so that is no drop-out.
It is a freeze where it lasts, the command changes meanwhile, the readings move in small steps before and after it, and it ends by one step far
larger than every other step of the log. Friction or a stop lets a rig go smoothly.
A rate leaps as well where friction lets go of a rig that is sampled slowly. So a rate's drop-out lies under a large command.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rwjax.kinds import is_angle
from rwjax.logs.log import Log
from rwjax.logs.noise_level import noise_level
from rwjax.rig.columns import unit_of

FEWEST = 10
"""Equal readings in a row from which they may be a drop-out, and readings beside them that have to move."""
LEAP = 3.0
"""Largest changes between other readings by which a drop-out is left [1]; what is smaller may be a fast motion between two samples."""
COUNTS, SIGMAS = 3.0, 6.0
"""Range of ten readings, in counts and in noise levels, above which they move: at rest it is a count or two, and three noise levels."""
LARGE = 0.5
"""Share of the largest command above which no friction holds a rig that moves at all [1]."""
PAUSE = 5.0
"""Time between two readings over the median one, from which nothing is known of the motion between them [1]."""

LASTS_S, COMMANDED, MOVING = 0.5, 0.1, 3
"""Least time of a freeze [s]; range of the command in it, over that in the log [1]; readings of `FEWEST` on each side that differ from their
neighbour."""


class Dropout(NamedTuple):
    """A stretch of equal readings that the rig did not have.

    Attributes:
        output: Name of the output.
        first: Index of its first sample.
        last: Index of its last sample.
        says: What it is and what to do, one sentence.
    """

    output: str
    first: int
    last: int
    says: str


def dropouts(log: Log) -> list[Dropout]:
    """The drop-outs of all outputs of a log.

    Args:
        log: The log.

    Returns:
        The drop-outs, output by output and in the order of time; none for a log as it should be.
    """
    return [found for name in log.outputs for found in _of_output(log, name)]


def freezes(log: Log) -> list[Dropout]:
    """Where angles stand still while the command changes, and then jump to where they would be.

    Args:
        log: The log.

    Returns:
        The freezes, output by output and in the order of time; none for a log as it should be, or a rig that friction or a stop holds.
    """
    return [found for found in leaps_after_rests(log) if _commanded(log, found.first, found.last)]


def leaps_after_rests(log: Log) -> list[Dropout]:
    """Where angles stand still and then jump, whatever the command does meanwhile.

    Args:
        log: The log.

    Returns:
        The rests, output by output and in the order of time.
    """
    return [found for name in log.outputs if is_angle(name) for found in _leaping(log, name)]


def without_dropouts(log: Log, found: Sequence[Dropout]) -> Log:
    """A log whose drop-outs are missing readings.

    Args:
        log: The log.
        found: Its drop-outs.

    Returns:
        The log, NaN in the place of each reading that is dropped out; the log itself where none is.
    """
    outputs, sample = dict(log.outputs), np.arange(len(log.time))
    for one in found:
        within = (sample >= one.first) & (sample <= one.last)
        outputs[one.output] = np.where(within, np.nan, outputs[one.output])
    return replace(log, outputs=outputs) if found else log


def equal_stretches(y: np.ndarray) -> np.ndarray:
    """Where readings stay the same.

    Args:
        y: Readings (n,) [any unit].

    Returns:
        First and last sample of every stretch of two equal readings or more (s, 2) [index].
    """
    same = np.diff(y) == 0.0
    ends = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(int), [0]])))
    return np.stack([ends[::2], ends[1::2]], axis=1)


def _of_output(log: Log, name: str) -> Iterator[Dropout]:
    """The drop-outs of one output."""
    seen = np.flatnonzero(np.isfinite(log.outputs[name]))
    y, time = log.outputs[name][seen], log.time[seen]
    stretches = equal_stretches(y)
    stretches = stretches[np.diff(stretches)[:, 0] + 1 >= FEWEST]
    if not len(stretches):
        return
    jump, step = np.abs(np.diff(y)), np.diff(time)
    goes_on = step <= PAUSE * float(np.median(step))
    other = goes_on.copy()
    other[[k for first, last in stretches for k in (first - 1, last) if 0 <= k < len(jump)]] = False
    fastest = float(np.max(jump[other], initial=0.0))
    moves = max(COUNTS * log.resolution.get(name, 0.0), SIGMAS * noise_level(y))
    for first, last in stretches:
        if first < FEWEST or last + FEWEST >= len(y):
            continue
        into, away = first - 1, last
        beside = y[first - FEWEST : first], y[last + 1 : last + 1 + FEWEST]
        way = fastest * (time[last + 1] - time[first - 1]) / float(np.median(step))
        left = goes_on[into] and goes_on[away] and min(jump[into], jump[away]) > LEAP * fastest > 0.0
        if left and abs(y[last + 1] - y[first - 1]) <= way and all(np.ptp(part) > moves for part in beside):
            a, b = int(seen[first]), int(seen[last])
            if _driven(log, name, a, b):
                yield Dropout(name, a, b, _says(log, name, a, b))


def _leaping(log: Log, name: str) -> Iterator[Dropout]:
    """The rests of one angle that end by a jump."""
    seen = np.flatnonzero(np.isfinite(log.outputs[name]))
    y, time = log.outputs[name][seen], log.time[seen]
    jump, step = np.abs(np.diff(y)), np.diff(time)
    stretches = [
        (first, last)
        for first, last in equal_stretches(y).tolist()
        if FEWEST <= first and last + FEWEST < len(y) and last - first + 1 >= FEWEST
        if time[last] - time[first] >= LASTS_S
        if all(np.sum(beside > 0.0) >= MOVING for beside in (jump[first - FEWEST : first], jump[last + 1 :][:FEWEST]))
    ]
    if not stretches:
        return
    goes_on = step <= PAUSE * float(np.median(step))
    other = goes_on.copy()
    other[[last for _, last in stretches]] = False
    fastest = float(np.max(jump[other], initial=0.0))
    for first, last in stretches:
        way = LEAP * fastest * (time[last + 1] - time[first]) / float(np.median(step))
        if np.all(goes_on[first - 1 : last + 1]) and LEAP * fastest < jump[last] <= way:
            a, b = int(seen[first]), int(seen[last])
            yield Dropout(name, a, b, _says_frozen(log, name, a, b, float(jump[last])))


def _commanded(log: Log, first: int, last: int) -> bool:
    """Whether the command changes between two samples, and torque is on."""
    given = log.command.reshape(len(log.time), -1)
    changes = np.ptp(given[first : last + 1], axis=0) > COMMANDED * np.ptp(given, axis=0)
    return bool(np.any(changes)) and (log.enabled is None or bool(np.all(log.enabled[first : last + 1])))


def _says_frozen(log: Log, name: str, first: int, last: int, jump: float) -> str:
    """What a freeze is and what to do."""
    count = log.resolution.get(name, 0.0)
    shown = f"{jump / count:.0f} counts" if count else f"{jump:.4g} {unit_of(name)}"
    return (
        f"{name} stands still from {log.time[first]:.6g} to {log.time[last]:.6g} s while the command changes, then jumps by {shown}: "
        "the sensor or the link stopped; leave those cells empty"
    )


def _driven(log: Log, name: str, first: int, last: int) -> bool:
    """Whether nothing but a drop-out ends a motion by a leap: torque is on, and of a rate the command is large."""
    if log.enabled is not None and not np.any(log.enabled[first : last + 1]):
        return False
    given = np.abs(log.at_drive.reshape(len(log.time), -1))
    return is_angle(name) or bool(np.any(np.median(given[first : last + 1], axis=0) > LARGE * given.max(axis=0)))


def _says(log: Log, name: str, first: int, last: int) -> str:
    """What a drop-out is and what to do."""
    begin, end, count = log.time[first], log.time[last], log.resolution.get(name, 0.0)
    value = log.outputs[name][first]
    shown = f"{value / count:.0f} counts" if count else f"{value:.6g} {unit_of(name)}"
    stays = f"{name} is exactly {shown} from {begin:.6g} to {end:.6g} s"
    return f"{stays}, and jumps there and back: a dropout? Leave those cells empty"
