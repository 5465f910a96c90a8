r"""Innovations: how likely a residual is where each reading is predicted from those before it.

A free run piles up everything small that is missing, and its residual is slow. Its square hardly tells two explanations apart that leave
about as much of that. So the residual of output $y$ is taken for an autoregression, whose noise is what a reading adds to the ones before:

$$ r_k = \sum_{j=1}^p a_j\, r_{k-j} + e_k, \qquad \ell = -\sum_y \tfrac12 n_y \ln \frac{1}{n_y} \sum_k e_k^2. $$

The coefficients $a_j$ are those of least squares, over all logs together; $\ell$ is the log likelihood but for a constant, and its mean is
$\ell / \sum_y n_y$.

Source:
    Ljung, System Identification (1999), section 7.4: maximum likelihood with a coloured noise model.
"""

from collections.abc import Sequence

import numpy as np

from rwjax.diagnosis.information_criterion import residuals
from rwjax.fitting.multiple_shooting import Fit


def log_likelihood(fitted: Fit, logs: Sequence[int], order: int) -> tuple[int, float]:
    """How many readings are predicted from those before them, and the mean log likelihood of one, where a fit's residuals are autoregressions.

    Args:
        fitted: the fit.
        logs: numbers of the logs.
        order: order p of the autoregressions [1].

    Returns:
        The number of readings of all outputs [1], and the mean up to a constant that all fits to the same logs share [1]; minus infinity
        where a run left the range of numbers.
    """
    total, count = 0.0, 0
    for name, series in residuals(fitted, logs).items():
        read = [fitted.problem.logs[k].outputs.get(name) for k in logs]
        e = innovations(_stretches(series, [np.isfinite(y) for y in read if y is not None]), order)
        total -= 0.5 * len(e) * float(np.log(max(np.mean(e**2), 1e-300))) if len(e) else 0.0
        count += len(e)
    return count, total / max(count, 1) if np.isfinite(total) else -np.inf


def _stretches(series: Sequence[np.ndarray], read: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The samples that were read, cut where the steps between them differ from the usual one of their log."""
    found = []
    for r, at in zip(series, read, strict=True):
        where = np.flatnonzero(at)
        steps = np.diff(where)
        if len(steps):
            found += np.split(r[where], np.flatnonzero(steps != np.median(steps)) + 1)
    return found


def innovations(series: Sequence[np.ndarray], order: int) -> np.ndarray:
    """What the samples add to what the ones before predict.

    Args:
        series: evenly spaced samples (time,) of one process, of any unit [any]; one array for each stretch.
        order: how many samples before each one predict it [1].

    Returns:
        The innovations of all stretches, one after the other, in the unit of the samples [any]; none of stretches no longer than the order, and infinite ones where a sample is not finite.
    """
    windows = [np.lib.stride_tricks.sliding_window_view(x, order + 1) for x in series if len(x) > order]
    if not windows:
        return np.zeros(0)
    rows = np.concatenate(windows)
    if not np.isfinite(rows).all():
        return np.full(len(rows), np.inf)
    before, now = rows[:, :-1], rows[:, -1]
    return now - before @ np.linalg.lstsq(before, now, rcond=None)[0]
