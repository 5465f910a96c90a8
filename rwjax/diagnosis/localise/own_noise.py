"""What the fitted rig's own free runs would have read, noise and counts included: the null of the tests of `where`."""

import numpy as np
from scipy.special import stdtr

from rwjax.fitting.multiple_shooting import Fit
from rwjax.logs.log import Log
from rwjax.simulation.rates import rates_along


def draws(fitted: Fit, log: Log, clean: np.ndarray, name: str, count: int, rng: np.random.Generator) -> np.ndarray:
    """Draws of what one output would have read: a simulated reading with noise, rounded to counts where the log is.

    Args:
        fitted: the fit, whose problem holds the noise.
        log: the log, which holds the resolution.
        clean: the output without noise (time,) [SI].
        name: the output.
        count: how many draws.
        rng: the source of randomness.

    Returns:
        Readings (time, draws) [SI].
    """
    step, noise = log.resolution.get(name, 0.0), fitted.problem.noise[name]
    if step == 0.0:
        return clean[:, None] + noise * rng.normal(size=(len(clean), count))
    white = np.sqrt(max(noise**2 - step**2 / 12.0, 0.0))
    # where the count turns over is not known, nor is it for the rig
    offset = step * rng.random(count)
    return step * np.round((clean[:, None] + offset + white * rng.normal(size=(len(clean), count))) / step) - offset


def rates(
    fitted: Fit, log: Log, theta: np.ndarray, states: dict[str, np.ndarray], command: np.ndarray, chunk: int
) -> dict[str, np.ndarray]:
    """Rates of change of all states along given motions.

    Args:
        fitted: the fit, whose structure is used.
        log: the log, for its time and what it adds to the numbers.
        theta: parameter vector (t,) [SI].
        states: motions (time, …) by state [SI]; those not given are 0.
        command: the command (time,) or (time, …) [V].
        chunk: samples of one call.

    Returns:
        Rates (time, …) by state [SI/s].
    """
    structure = fitted.problem.structure
    shape = np.broadcast_shapes(*(x.shape for x in states.values()))
    of_time = (slice(None), *[None] * (len(shape) - 1))
    X = np.stack([np.broadcast_to(states.get(s, 0.0), shape).ravel() for s in structure.states], axis=1)
    t, u = (np.broadcast_to(v[of_time] if v.ndim == 1 else v, shape).ravel() for v in (log.time - log.origin, command))
    n = len(t)
    size = -(-n // chunk) * chunk
    X, t, u = (np.pad(a, [(0, size - n)] + [(0, 0)] * (a.ndim - 1), mode="edge") for a in (X, t, u))
    theta = theta + np.array(structure.vector(log.added))
    on = None
    if structure.switched:
        enabled = np.ones(len(log.time), bool) if log.enabled is None else log.enabled
        on = np.pad(np.broadcast_to(enabled[of_time], shape).ravel(), (0, size - n), mode="edge")
    parts = [
        rates_along(structure, theta, t[at], X[at], u[at], None if on is None else on[at])
        for at in (slice(k, k + chunk) for k in range(0, size, chunk))
    ]
    found = np.concatenate([np.asarray(part) for part in parts])[:n]
    return {s: found[:, k].reshape(shape) for k, s in enumerate(structure.states)}


def above(value: float, null: np.ndarray) -> float:
    """Probability [1] that a positive statistic is this large by chance: Student's t for its logarithm.

    Args:
        value: the statistic, whose unit is that of its draws [1].
        null: draws of it where nothing is missing (draws,) [1].

    Returns:
        The probability [1].
    """
    draws = np.log(np.maximum(null, 1e-300))
    spread = max(float(np.std(draws, ddof=1)), 1e-9) * np.sqrt(1.0 + 1.0 / len(draws))
    return float(stdtr(len(draws) - 1, (np.mean(draws) - np.log(max(value, 1e-300))) / spread))
