"""Plateaus: the stretches of a log in which the command stays the same and the wheel's speed has settled.

The settled part begins two time constants after the last change that is seen. What is left of a decaying transient is then
small against the noise. The time constant is the transient's area over its height. A part that still drifts beyond its
noise is no plateau.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.fitting.sandwich import meat
from rwjax.logs.log import Log
from rwjax.logs.noise import quantisation
from rwjax.logs.noise_level import noise_level
from rwjax.methods.identified import student

BLOCKS = 24
"""Parts of a stretch whose speeds are compared."""
LAST = 6
"""Parts at its end that the others are compared with."""
FEWEST = 4 * BLOCKS
"""Readings below which a stretch is too short."""
SAME = 8.0
"""Distance of a command from the first one of its stretch, in units of its noise, up to which it counts as the same [1]."""
SEEN = 3.0
"""Standard errors from which on a change counts as seen [1]."""
NEAR = 2.0
"""Standard errors up to which a part's speed counts as the last one [1]."""
SLOW = 20
"""Part of a stretch over which noise has lost half of its correlation at least."""
MARGIN = 2.0
"""Time constants of the change from the time at which it is seen no more to the settled part [1]."""
MOST_ALIKE = 0.97
"""Largest correlation of neighbouring readings that counts as noise [1] (Andrews and Monahan)."""
FINEST, TINY = 1e-6, 1e-12
"""Least noise of a reading over its largest value [1], and of any reading [SI]: digits are no motion."""


@dataclass(frozen=True)
class Mean:
    """A mean with its standard error.

    Attributes:
        value: The mean [SI].
        error: Its standard error [SI].
    """

    value: float
    error: float


@dataclass(frozen=True)
class Plateau:
    """The settled part of a stretch with the same command.

    Attributes:
        log: Name of the log.
        begin: Time from which on the speed is settled [s].
        volts: Mean command [V].
        speed: Mean speed of the wheel [rad/s].
        current: Mean current [A]; None where it is not measured.
    """

    log: str
    begin: float
    volts: float
    speed: Mean
    current: Mean | None


def plateaus(log: Log) -> tuple[list[Plateau], list[float]]:
    """The plateaus of a log.

    Args:
        log: The log, of a rig with one wheel.

    Returns:
        The plateaus, and the times [s] at which stretches begin whose speed does not settle; none of either where the
        wheel's speed is not measured.
    """
    name = next((name for name in ("wheel_rad_s", "wheel_rad") if name in log.outputs), None)
    if name is None:
        return [], []
    seen = np.isfinite(log.outputs[name])
    settled, unsettled = [], []
    for first, last in _stretches(log.command):
        index = first + np.flatnonzero(seen[first:last])
        if len(index) < FEWEST:
            continue
        t, y = log.time[index], log.outputs[name][index]
        order = 1 if name == "wheel_rad" else 0
        floor = _least_noise(log, name, y - order * y[0])
        begin = _settled_from(t, y, order, floor)
        if begin is None:
            unsettled.append(float(log.time[first]))
            continue
        part = slice(int(index[begin]), last)
        speed = Mean(*_coefficient(t[begin:], y[begin:], order, order, floor))
        settled.append(
            Plateau(log.name, float(t[begin]), float(np.mean(log.command[part])), speed, _current(log, part))
        )
    return settled, unsettled


def _stretches(command: np.ndarray) -> list[tuple[int, int]]:
    """First index, and the one after the last, of every stretch in which the command stays the same, long enough for a plateau."""
    reach = max(SAME * noise_level(command), 1e-9 * float(np.max(np.abs(command), initial=0.0)))
    found, first = [], 0
    while first + FEWEST <= len(command):
        last = _until(command[first : first + FEWEST], reach)
        if last == FEWEST:  # only then the whole rest is looked at: a command may change with every sample
            last = _until(command[first:], reach)
            found.append((first, first + last))
        first += last
    return found


def _until(command: np.ndarray, reach: float) -> int:
    """Number of samples at the beginning that are as the first one."""
    away = np.abs(command - command[0]) > reach
    return int(np.argmax(away)) if away.any() else len(command)


def _coefficient(t: np.ndarray, y: np.ndarray, order: int, which: int, floor: float) -> tuple[float, float]:
    """Coefficient of a power of time in a polynomial through readings, and its error where their noise is correlated.

    The noise is whitened by its first-order correlation before its covariance is taken (Andrews and Monahan, Econometrica
    60, 1992), and that correlation is freed of its bias (Kendall, Biometrika 41, 1954).
    """
    scale = t[-1] - t[0]
    A = ((t - t.mean()) / scale)[:, None] ** np.arange(order + 1)
    inverse = np.linalg.inv(A.T @ A)
    fitted = inverse @ (A.T @ y)
    rest = y - A @ fitted
    alike = float(rest[1:] @ rest[:-1]) / max(float(rest @ rest), 1e-300)
    alike = min(max(alike + (1.0 + 3.0 * alike) / len(y), 0.0), MOST_ALIKE)
    white = (rest[1:] - alike * rest[:-1]) / (1.0 - alike)
    correlated = inverse @ meat([A[1:, None]], [white[:, None]]) @ inverse
    # independent readings beyond the coefficients
    worth = max(len(y) * (1.0 - alike) / (1.0 + alike) - order - 1.0, 1.0)
    error = student(worth) * np.sqrt(max(correlated[which, which], inverse[which, which] * floor**2))
    return float(fitted[which] / scale**which), float(error / scale**which)


def _settled_from(t: np.ndarray, y: np.ndarray, order: int, floor: float) -> int | None:
    """Index of the first reading of the settled part; None where the speed does not settle.

    The speed is the coefficient of time to the power `order` in the readings.
    """
    edges = np.linspace(0, len(t), BLOCKS + 1).astype(int)
    speeds = np.array([np.polyfit(t[a:b] - t[a], y[a:b], order)[0] for a, b in zip(edges[:-1], edges[1:], strict=True)])
    tail = edges[-1 - LAST]
    end, error = _coefficient(t[tail:], y[tail:], order, order, floor)
    # a shorter part by the factor n has a mean with n, and a slope with n^3 times the variance
    near = np.abs(speeds - end) < NEAR * error * np.sqrt(1.0 + LAST ** (1 + 2 * order))
    calm = np.flatnonzero(near[:-1] & near[1:])
    if not len(calm):
        return None
    seen = np.abs(speeds - end)[: calm[0]]
    lasts = float(np.sum(seen) / np.max(seen)) if np.any(seen) else 0.0
    begin = int(edges[calm[0]] + MARGIN * lasts * len(t) / BLOCKS)
    if begin > tail:
        return None
    t, y = t[begin:], y[begin:]
    drift, error = _coefficient(t, y, order + 1, order + 1, floor)
    return None if abs(drift) > SEEN * error or _creeps(t, y, order, floor) else begin


def _creeps(t: np.ndarray, y: np.ndarray, order: int, floor: float) -> bool:
    """Whether readings wander from a steady motion so slowly that this is motion and no noise."""
    rest = y - np.polyval(np.polyfit(t - t[0], y, order), t - t[0])
    lag = len(rest) // SLOW
    return bool(np.std(rest) > floor) and float(rest[lag:] @ rest[:-lag]) > 0.5 * float(rest @ rest)


def _current(log: Log, part: slice) -> Mean | None:
    """Mean current over a part of a log."""
    if "current_A" not in log.outputs:
        return None
    seen = np.isfinite(log.outputs["current_A"][part])
    t, i = log.time[part][seen], log.outputs["current_A"][part][seen]
    if len(i) < LAST:
        return None
    return Mean(*_coefficient(t, i, 0, 0, _least_noise(log, "current_A", i)))


def _least_noise(log: Log, name: str, readings: np.ndarray) -> float:
    """Standard deviation that the noise of readings has at least."""
    return max(quantisation(log, name), FINEST * float(np.max(np.abs(readings))), TINY)


def without_standing(found: Sequence[Plateau]) -> tuple[list[Plateau], list[Plateau]]:
    """Plateaus on which the wheel turns, and those on which it stands.

    Args:
        found: All plateaus.

    Returns:
        Both.
    """
    turns = [abs(p.speed.value) > SEEN * p.speed.error for p in found]
    return [p for p, t in zip(found, turns, strict=True) if t], [p for p, t in zip(found, turns, strict=True) if not t]
