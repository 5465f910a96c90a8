"""Plateaus: the stretches of a log in which the command stays the same and the wheel's speed has settled.

The settled part begins at one and a half times the time after which no change is seen any more. What is left of a decaying
transient is then small against the noise. A part that still drifts beyond its noise is no plateau.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.fitting.sandwich import meat
from rwjax.logs.log import Log
from rwjax.logs.noise import noise_level, quantisation

BLOCKS = 24
"""Parts of a stretch whose speeds are compared."""
LAST = 8
"""Parts at its end that the others are compared with."""
FEWEST = 4 * BLOCKS
"""Readings below which a stretch is too short."""
SAME = 8.0
"""Distance of a command from the first one of its stretch, in units of its noise, up to which it counts as the same [1]."""
SEEN = 3.0
"""Standard errors from which on a change counts as seen [1]."""
MARGIN = 1.5
"""Begin of the settled part over the time from which on no change is seen [1]."""
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
    while first < len(command):
        away = np.flatnonzero(np.abs(command[first:] - command[first]) > reach)
        last = first + int(away[0]) if len(away) else len(command)
        if last - first >= FEWEST:
            found.append((first, last))
        first = last
    return found


def _coefficient(t: np.ndarray, y: np.ndarray, order: int, which: int, floor: float) -> tuple[float, float]:
    """Coefficient of a power of time in a polynomial through readings, and its error where their noise is correlated."""
    scale = t[-1] - t[0]
    A = ((t - t.mean()) / scale)[:, None] ** np.arange(order + 1)
    inverse = np.linalg.inv(A.T @ A)
    fitted = inverse @ (A.T @ y)
    correlated = inverse @ meat([A[:, None]], [(y - A @ fitted)[:, None]]) @ inverse
    error = np.sqrt(max(correlated[which, which], inverse[which, which] * floor**2))
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
    near = np.abs(speeds - end) < SEEN * error * np.sqrt(1.0 + LAST ** (1 + 2 * order))
    calm = np.flatnonzero(near[:-1] & near[1:])
    if not len(calm):
        return None
    begin = int(MARGIN * edges[calm[0]])
    if begin > tail:
        return None
    drift, error = _coefficient(t[begin:], y[begin:], order + 1, order + 1, floor)
    return begin if abs(drift) < SEEN * error else None


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
