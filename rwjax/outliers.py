"""Readings that cannot be: a few samples far outside what lies around them, as a lost byte or a spark makes them.

No model is asked. A body with inertia changes its angle and its rate little from sample to sample; readings are outliers
where one, or up to three in a row, lie outside the range of those before and after by more than three times the largest
change among these and twelve times the noise. What a model may have to explain (a jump that stays, a kink, a slow
deviation) is kept.
"""

import numpy as np

from rwjax import noise

AROUND = 3
"""Readings on either side with which a suspect is compared."""
LONGEST = 3
"""Readings in a row that may be outliers together."""
CHANGES, SIGMAS = 3.0, 12.0
MOST = 0.05
"""Share of the readings above which they are not exceptions, and all are kept."""


def outliers(y: np.ndarray, command: np.ndarray | None = None) -> np.ndarray:
    """Which of an output's readings (NaN where there is none) are outliers.

    With a `command`, a stretch in which it changes is not suspected: a current may follow it within a sample.
    """
    found = np.zeros(len(y), bool)
    index = np.flatnonzero(np.isfinite(y))
    value = y[index] / max(np.max(np.abs(y[index]), initial=0.0), 1e-300)
    distinct = np.diff(np.unique(value))
    unit = max(noise.rapid(value), float(distinct.min())) if len(distinct) else 0.0
    for length in range(1, LONGEST + 1):
        size = length + 2 * AROUND
        if len(value) < size:
            break
        windows = np.lib.stride_tricks.sliding_window_view(value, size)
        inside = windows[:, AROUND:-AROUND]
        around = np.concatenate([windows[:, :AROUND], windows[:, -AROUND:]], axis=1)
        low, high = np.min(around, axis=1, keepdims=True), np.max(around, axis=1, keepdims=True)
        margin = CHANGES * np.max(np.abs(np.diff(around, axis=1)), axis=1, keepdims=True) + SIGMAS * unit
        suspect = np.all((inside > high + margin) | (inside < low - margin), axis=1)
        if command is not None:
            held = np.lib.stride_tricks.sliding_window_view(command[index], size)
            suspect &= np.ptp(held, axis=1) == 0.0
        for first in np.flatnonzero(suspect) + AROUND:
            found[index[first : first + length]] = True
    return found if np.sum(found) <= MOST * len(index) else np.zeros(len(y), bool)
