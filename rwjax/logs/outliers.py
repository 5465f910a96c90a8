"""Outliers: a few readings far outside what lies around them, as a lost byte or a spark makes them.

No model is asked. A body with inertia changes its angle and its rate little from sample to sample. Readings are outliers

* where up to three in a row lie outside the range of the three before and the three after (at the ends of a log: the six on
  the one side) by more than three times the largest change among these six plus eight times the noise;
* where one lies outside the band of the middle 98 % of all readings by more than the band's width plus eight times the
  noise, and most of the six around it lie inside. This finds outliers near one another, which the first rule misses.

What a model may have to explain (a jump that stays, a kink, a slow deviation) is kept.

A log may begin with a step. A current that begins with its inrush decays from its first reading on: where the second is at most half as
far off, above the noise, and the third goes on as fast, none of the three is an outlier.

A log may begin with a step from rest: its first command is not 0, and its first readings come from before the rig has moved. Of the
first three under such a command only those are outliers that no motion between rest and the other readings has.
"""

import numpy as np

from rwjax.logs.noise_level import noise_level

AROUND = 3
"""Readings on either side with which a suspect is compared."""
LONGEST = 3
"""Readings in a row that may be outliers together."""
CHANGES, SIGMAS = 3.0, 8.0
"""Largest changes of the surroundings, and noise levels, by which a suspect has to lie outside."""
MOST = 0.05
"""Share of the readings above which they are not exceptions, and all are kept."""
HALF, AS_FAST = 0.5, 2.0
"""What a decay leaves of the first reading's distance at most; times what it would leave of the second's, up to which it goes on [1, 1]."""
ANSWER = 15
"""Samples for which a rate or a current may answer a change of the command by a leap."""


def outliers(time: np.ndarray, y: np.ndarray, command: np.ndarray | None = None) -> np.ndarray:
    """Which of an output's readings are outliers.

    Args:
        time: Time [s] (n,).
        y: Readings (n,) [any unit], NaN where there is none.
        command: Command [V] (n,) or (n, 2), for an output that may answer a change of it by a leap: readings less
            than `ANSWER` samples after a change are then not suspected.

    Returns:
        Which are outliers (n,) [true or false]; none where they are more than the share `MOST`.
    """
    seen = np.isfinite(y)
    if seen.sum() < 2 * AROUND + LONGEST:
        return np.zeros(len(y), bool)
    value = y / max(float(np.max(np.abs(y[seen]))), 1e-300)
    distinct = np.diff(np.unique(value[seen]))
    unit = max(noise_level(value[seen]), float(distinct.min())) if len(distinct) else 0.0
    may = seen
    if command is not None:
        may = seen & ~(_answers(command) | _starts(command, value, unit) | _decays(command, value, unit))
    longest_gap = (LONGEST + 1.5) * float(np.median(np.diff(time)))
    found = np.zeros(len(y), bool)
    while True:
        index = np.flatnonzero(seen & ~found)
        suspects = [_outside_band(value[index], unit)]
        for length in range(1, LONGEST + 1):
            for before in (AROUND, 0, 2 * AROUND):  # before == 0: the log's first readings; 2 * AROUND: its last
                suspects.append(_outside_surroundings(time[index], value[index], length, before, unit, longest_gap))
        new = np.zeros(len(y), bool)
        new[index[np.concatenate(suspects)]] = True
        new &= may
        if not new.any():
            return found if np.sum(found) <= MOST * np.sum(seen) else np.zeros(len(y), bool)
        found |= new


def _answers(command: np.ndarray) -> np.ndarray:
    """Readings that may lie off their surroundings because the command changes.

    They come after a change. Where the command changes within the log's first readings, so do the readings before
    it, since they are compared with readings after it.
    """
    changed = np.append(False, np.diff(command.reshape(len(command), -1), axis=0).any(axis=1))
    first = 2 * AROUND + LONGEST
    answers = np.convolve(changed, np.ones(ANSWER + 1))[: len(changed)] > 0.5
    answers[:first] |= changed[:first].any()
    return answers


def _starts(command: np.ndarray, value: np.ndarray, unit: float) -> np.ndarray:
    """Readings that may lie off their surroundings because the log begins with a step from rest.

    They are the first ones under a first command that is not 0, as many as may be outliers together, and lie within the range of rest
    and nearly all later readings, widened by its width and the noise.
    """
    seen = np.isfinite(value)
    first = seen & (np.cumsum(seen) <= LONGEST) & (np.arange(len(value)) < ANSWER)
    if not np.any(command[0]):
        return np.zeros(len(value), bool)
    low, high = np.percentile(np.append(value[seen & ~first], 0.0), (1.0, 99.0))  # a later outlier hides none of these
    low, high = min(low, 0.0), max(high, 0.0)
    margin = (high - low) + SIGMAS * unit
    return first & (value >= low - margin) & (value <= high + margin)


def _decays(command: np.ndarray, value: np.ndarray, unit: float) -> np.ndarray:
    """The first three readings where they decay to those after them, under a first command that is not 0.

    The second is at most half as far from the median of the next as the first, on the same side, and farther than the noise. From there
    the distance falls as from the first to the second, or faster. A lost byte before a slow motion leaves a third one nearly as far off as
    the second; so the noise that the third may have is half of that which the second has to exceed.
    """
    first, kept = np.flatnonzero(np.isfinite(value))[: LONGEST + 2 * AROUND], np.zeros(len(value), bool)
    settled = float(np.median(value[first[LONGEST:]]))
    begin, then, last = value[first[:LONGEST]] - settled
    falls = begin * then > 0.0 and SIGMAS * unit < abs(then) <= HALF * abs(begin) and first[LONGEST - 1] < ANSWER
    if np.any(command[0]) and falls and abs(last) <= AS_FAST * then**2 / abs(begin) + SIGMAS / 2.0 * unit:
        kept[first[:LONGEST]] = True
    return kept


def _outside_surroundings(
    time: np.ndarray, value: np.ndarray, length: int, before: int, unit: float, longest_gap: float
) -> np.ndarray:
    """Indices of the readings of every `length` in a row that lie outside their surroundings, `before` of which come first."""
    size = length + 2 * AROUND
    if len(value) < size:
        return np.zeros(0, int)
    starts = {0: np.array([0]), 2 * AROUND: np.array([len(value) - size])}.get(before, np.arange(len(value) - size + 1))
    windows = value[starts[:, None] + np.arange(size)]
    gaps = np.max(np.diff(time[starts[:, None] + np.arange(size)], axis=1), axis=1)
    inside = windows[:, before : before + length]
    around = np.delete(windows, np.s_[before : before + length], axis=1)
    changes = np.max(np.abs(np.diff(around, axis=1)), axis=1, keepdims=True)
    margin = (CHANGES * changes + SIGMAS * unit) * (1.0 if before == AROUND else length + 1.0)
    low, high = np.min(around, axis=1, keepdims=True), np.max(around, axis=1, keepdims=True)
    suspect = np.all((inside > high + margin) | (inside < low - margin), axis=1) & (gaps < longest_gap)
    return (starts[suspect][:, None] + before + np.arange(length)).ravel()


def _outside_band(value: np.ndarray, unit: float) -> np.ndarray:
    """Indices of readings that lie far outside the band of nearly all readings, with most of their neighbours within it."""
    low, high = np.percentile(value, (1.0, 99.0))
    margin = (high - low) + SIGMAS * unit
    within = (value >= low) & (value <= high)
    neighbours = np.convolve(within, np.ones(2 * AROUND + 1))[AROUND:-AROUND] - within
    return np.flatnonzero(((value > high + margin) | (value < low - margin)) & (neighbours > AROUND))
