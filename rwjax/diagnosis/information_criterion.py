r"""Information criterion of a hypothesis, with the number of independent samples that its residual allows.

The residual of output $y$ has the sum of squares $S_y$ and $n_y$ effective samples. A hypothesis with $k$ numbers that say that
something is missing, and $f$ numbers of its effects' forms, has the criterion

$$ -\sum_y \tfrac12 n_y \ln S_y - \tfrac12 k \ln \sum_y n_y - f. $$

The noise variance is profiled out. Larger is better, and differences are in units of a log evidence (minus half of the usual scale).
The $k$ numbers are counted as in Schwarz's criterion (Ann. Stat. 6 (1978)), the $f$ numbers as in Akaike's: no form is more likely
beforehand for having fewer numbers. Residuals of a wrong or incomplete model are correlated. If every sample counted, something
would be named on every rig.
"""

from collections.abc import Sequence

import numpy as np

from rwjax.fitting.multiple_shooting import Fit
from rwjax.simulation.batch import by_sample


def residuals(fitted: Fit, logs: Sequence[int]) -> dict[str, list[np.ndarray]]:
    """Residuals of a fit by output [1], in units of the noise.

    Args:
        fitted: the fit.
        logs: numbers of the logs.

    Returns:
        By output, one array (time,) for each log that holds it, with 0 for missing readings.
    """
    problem = fitted.problem
    found: dict[str, list[np.ndarray]] = {}
    for k in logs:
        record = problem.logs[k]
        r = by_sample(problem.batch, k, fitted.evaluation.residual[k], len(record.time))
        for y, name in enumerate(problem.structure.outputs):
            if name in record.outputs:
                found.setdefault(name, []).append(r[:, y])
    return found


def correlation_time(series: np.ndarray) -> float:
    r"""Number of samples [1] that count as one independent sample.

    $1 + 2\sum_k \rho_k$ over the initial positive autocorrelations $\rho_k$ about zero, where a perfect model's residual lies.

    Args:
        series: samples (time,), of any unit [1].

    Returns:
        The number of samples [1], at least 1.

    Source:
        Geyer, Practical Markov Chain Monte Carlo, Stat. Sci. 7 (1992).
    """
    n = len(series)
    size = 1 << (2 * n - 1).bit_length()
    power = np.abs(np.fft.rfft(series, size)) ** 2
    covariance = np.fft.irfft(power, size)[: n // 2]
    if covariance[0] <= 0.0:
        return 1.0
    rho = covariance / covariance[0]
    stop = np.flatnonzero(rho <= 0.0)
    return float(1.0 + 2.0 * np.sum(rho[1 : stop[0] if len(stop) else len(rho)]))


def effective_samples(r: dict[str, list[np.ndarray]]) -> dict[str, float]:
    """Independent samples [1] of each output's residual, over all logs.

    Args:
        r: residuals as `residuals` gives them [1].

    Returns:
        Number of independent samples by output [1], at least one a log.
    """
    return {name: sum(max(len(x) / correlation_time(x), 1.0) for x in series) for name, series in r.items()}


def sums_of_squares(r: dict[str, list[np.ndarray]]) -> dict[str, float]:
    """Sum of squares of each output's residual [1].

    Args:
        r: residuals as `residuals` gives them [1].

    Returns:
        Sum by output [1], infinite where a run left the range of numbers.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        found = {name: float(sum(np.sum(x**2) for x in series)) for name, series in r.items()}
    return {name: value if np.isfinite(value) else np.inf for name, value in found.items()}


def information_criterion(squares: dict[str, float], numbers: int, form: int, effective: dict[str, float]) -> float:
    """Information criterion [1]; larger is better (equation in the module's docstring).

    Args:
        squares: sum of squares of the residual by output [1].
        numbers: fitted numbers that say that something is missing.
        form: fitted numbers that say in which form.
        effective: independent samples by output [1].

    Returns:
        The criterion up to a constant that all hypotheses of the same logs share [1].
    """
    fit = -0.5 * sum(effective[name] * np.log(max(squares[name], 1e-300)) for name in squares)
    return float(fit - 0.5 * numbers * np.log(sum(effective.values())) - form)
