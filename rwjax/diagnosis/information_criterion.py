r"""Evidence for one hypothesis against another, with the number of independent samples that the residual allows.

With residual sums of squares $S_y$ of output $y$ and $n_y$ effective samples, the log evidence of an hypothesis with
$k$ numbers of its own and $f$ of its effects' forms is $-\sum_y \tfrac12 n_y \ln S_y - \tfrac12 k \ln \sum_y n_y - f$: with the
noise variance profiled out, what says that something is missing counts as Schwarz has it (Ann. Stat. 6 (1978)), and what says
in which form as Akaike has it, since no form is more likely beforehand for having fewer numbers. Residuals of a wrong or
incomplete model are correlated; counting every sample would name something on every rig.
"""

import numpy as np

from rwjax.fitting.multiple_shooting import Fit
from rwjax.simulation.batch import by_sample


def residuals(fitted: Fit, logs: tuple[int, ...]) -> dict[str, list[np.ndarray]]:
    """Residual in units of noise by output, one array for each log that holds it (missing readings 0)."""
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
    """Samples that count as one: $1 + 2\\sum\\rho_k$ over the initial positive correlations (Geyer 1992)."""
    n = len(series)
    size = 1 << (2 * n - 1).bit_length()
    power = np.abs(np.fft.rfft(series, size)) ** 2  # about zero, where a perfect model's residual lies
    covariance = np.fft.irfft(power, size)[: n // 2]
    if covariance[0] <= 0.0:
        return 1.0
    rho = covariance / covariance[0]
    stop = np.flatnonzero(rho <= 0.0)
    return float(1.0 + 2.0 * np.sum(rho[1 : stop[0] if len(stop) else len(rho)]))


def effective_samples(r: dict[str, list[np.ndarray]]) -> dict[str, float]:
    """Independent samples of each output's residual, over all logs."""
    return {name: sum(max(len(x) / correlation_time(x), 1.0) for x in series) for name, series in r.items()}


def sums(r: dict[str, list[np.ndarray]]) -> dict[str, float]:
    """Sum of squares of each output's residual, infinite where a run left the range of numbers."""
    with np.errstate(over="ignore", invalid="ignore"):
        found = {name: float(sum(np.sum(x**2) for x in series)) for name, series in r.items()}
    return {name: value if np.isfinite(value) else np.inf for name, value in found.items()}


def log_evidence(squares: dict[str, float], numbers: int, form: int, effective: dict[str, float]) -> float:
    """Log evidence up to a constant that all hypotheses of the same logs share."""
    fit = -0.5 * sum(effective[name] * np.log(max(squares[name], 1e-300)) for name in squares)
    return float(fit - 0.5 * numbers * np.log(sum(effective.values())) - form)
