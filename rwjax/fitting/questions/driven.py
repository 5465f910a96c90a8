"""Whether a motion has anything to do with its command, whatever the rig: nothing is simulated here."""

import numpy as np

from rwjax.fitting.initial_guess import START_S
from rwjax.kinds import is_angle
from rwjax.logs.log import Log

SEGMENTS = 8
"""Parts of a run over which the coherence is averaged [1]."""
LEAST_CHANGING = 4
"""Parts of a run in which the command has to change to say anything [1]."""
FEWEST, SHORTEST_S = 256, 1.0
"""Samples [1], and length of a run [s], below which nothing can be said: the averages and the lags below have to fit in."""
SMOOTHED_S = 0.15
"""Time over which readings and command are averaged before they are differentiated [s]."""
LAGS_S = (0.0, 0.05, 0.1, 0.15, 0.2)
"""Times by which the command may act late [s]."""
CREEP = 0.1
"""Rate, as a share of its standard deviation, at which dry friction counts as turned over [1]."""


def coherent_share(log: Log) -> float:
    r"""Share of a motion's power that is linear in the command, whatever the dynamics between them.

    The mean over frequencies of $|S_{uy}|^2 / (S_{uu} S_{yy})$, weighted by $S_{yy}$ (Welch's method); of unrelated
    signals it is about one over the number of segments.

    Args:
        log: The log.

    Returns:
        The largest share of any reading with any command [1]; 1 where the log cannot tell.
    """
    return max((_coherence(y, u, dt, is_angle(name)) for name, y, u, dt in _signals(log)), default=1.0)


def driven_share(log: Log) -> float:
    """Correlation of the acceleration with the command, after what position and rate explain is taken from both.

    So friction, gravity, back-EMF and a controller that reads the motion do not count, and an unstable rig is no
    exception.

    Args:
        log: The log.

    Returns:
        The largest correlation of any reading with any command [1]; 1 where the log cannot tell.
    """
    turning = [(name, y, u, dt) for name, y, u, dt in _signals(log) if not name.startswith("current")]
    return max((_driven(y, u, dt, is_angle(name)) for name, y, u, dt in turning), default=1.0)


def _signals(log: Log) -> list[tuple[str, np.ndarray, np.ndarray, float]]:
    """Name, readings [SI] and command [V] at equal intervals, and the interval [s], for every reading and every command."""
    interval = float(np.median(np.diff(log.time)))
    time = np.arange(log.time[0], log.time[-1], interval)
    if len(time) < FEWEST or log.time[-1] - log.time[0] < SHORTEST_S:
        return []
    at = np.searchsorted(log.time, time, side="right") - 1
    commands = [u[at] for u in log.at_drive.reshape(len(log.at_drive), -1).T if _changes(u)]
    found = []
    for name, values in log.outputs.items():
        seen = np.isfinite(values)
        found += [(name, np.interp(time, log.time[seen], values[seen]), u, interval) for u in commands]
    return found


def _changes(command: np.ndarray) -> bool:
    """Whether a command changes in most parts of a run."""
    return sum(bool(np.ptp(part)) for part in np.array_split(command, SEGMENTS)) >= LEAST_CHANGING


def _coherence(y: np.ndarray, u: np.ndarray, interval: float, angle: bool) -> float:
    """Coherence of readings with a command [1]."""
    from scipy.signal import csd, welch  # half a second to import, and needed where something is wrong alone

    lag = round(START_S / interval)
    if angle:  # a change of the angle beside the impulse of the command in the same time
        total = np.cumsum(u) * interval
        y, u = y[lag:] - y[:-lag], total[lag:] - total[:-lag]
    per_segment = len(y) // SEGMENTS
    both = csd(u, y, nperseg=per_segment)[1]
    of_command, of_motion = (welch(x, nperseg=per_segment)[1] for x in (u, y))
    power = of_command * of_motion
    share = np.divide(np.abs(both) ** 2, power, out=np.zeros(len(power)), where=power > 0.0)
    return float(share @ of_motion / of_motion.sum()) if of_motion.any() else 1.0


def _mean(values: np.ndarray, width: int) -> np.ndarray:
    """Running mean over so many samples."""
    return np.convolve(values, np.full(width, 1.0 / width), "valid")


def _driven(y: np.ndarray, u: np.ndarray, interval: float, angle: bool) -> float:
    """Partial correlation of the acceleration with the command given position and rate [1]."""
    w = max(2, round(SMOOTHED_S / interval))
    smooth, ramp = _mean(y, w), np.linspace(-1.0, 1.0, len(y))
    if angle:  # second difference over w: the acceleration's mean under a triangle
        here, rate = smooth[w:-w], smooth[2 * w :] - smooth[: -2 * w]
        acceleration = smooth[2 * w :] - 2.0 * here + smooth[: -2 * w]
        command = _mean(_mean(_mean(u, w), w), w)[1:-1]
        position = [here, np.sin(here), np.cos(here)]
    else:  # difference over 2w: its mean over as much
        rate, acceleration = smooth[w:-w], smooth[2 * w :] - smooth[: -2 * w]
        command = _mean(_mean(u, w), 2 * w)[1:]
        position = [ramp[: len(rate)]]
    turned_over = np.tanh(rate / (CREEP * np.std(rate) + np.finfo(float).tiny))
    state = np.stack([np.ones(len(rate)), rate, turned_over, *position], axis=1)
    basis = np.linalg.qr(state / np.maximum(np.abs(state).max(axis=0), np.finfo(float).tiny))[0]
    lags = {round(lag / interval) for lag in LAGS_S}
    return max(_correlation(basis, acceleration, np.append(np.full(n, command[0]), command)[: len(rate)]) for n in lags)


def _correlation(basis: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """Size of the correlation of two signals without what lies in a basis [1]."""
    a, b = a - basis @ (basis.T @ a), b - basis @ (basis.T @ b)
    size = float(np.sqrt((a @ a) * (b @ b)))
    return abs(float(a @ b)) / size if size > 0.0 else 0.0
