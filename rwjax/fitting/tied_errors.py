"""Standard errors of numbers that follow from others, by the delta method."""

from collections.abc import Mapping, Sequence

import numpy as np

from rwjax.rig.tied import completed

STEP = 1e-6
"""Change of a number [1], as a share of its size, over which the slope of a formula is taken to both sides."""


def tied_errors(
    tied: Mapping[str, str], values: Mapping[str, float], names: Sequence[str], covariance: np.ndarray
) -> dict[str, float]:
    r"""Standard errors of numbers that follow from estimated ones: $\sqrt{g^\top C g}$ with the slopes $g$ of their formulas.

    Args:
        tied: Formulas by the name of the number, each behind those on which it depends.
        values: All numbers [SI].
        names: The estimated numbers.
        covariance: Their covariance `(k, k)` [SI²], infinite where the logs do not tell them.

    Returns:
        Standard error of each number that depends on an estimated one [SI]; none where that one's is infinite.
    """
    slopes = np.zeros((len(tied), len(names)))
    for k, name in enumerate(names):
        step = STEP * max(abs(values[name]), 1e-9)
        ends = [completed(tied, {**values, name: values[name] + side * step}) for side in (1.0, -1.0)]
        slopes[:, k] = [(ends[0][one] - ends[1][one]) / (2.0 * step) for one in tied]
    found = {}
    for name, slope in zip(tied, slopes, strict=True):
        moved = np.flatnonzero(slope)
        variance = slope[moved] @ covariance[np.ix_(moved, moved)] @ slope[moved]
        if len(moved) and np.isfinite(variance):
            found[name] = float(np.sqrt(variance))
    return found
