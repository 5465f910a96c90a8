"""In which regime and in which frequency band the missing torque arises, each against what chance would give."""

from dataclasses import dataclass

import numpy as np

from rwjax.diagnosis.information_criterion import correlation_time
from rwjax.diagnosis.localise.own_noise import above
from rwjax.diagnosis.localise.spectrum import OctavePower
from rwjax.diagnosis.settings import RegimeSettings

REGIMES = ("stuck", "breaking away", "reversing", "saturated", "coasting", "sliding")
"""Every sample is in the first that holds."""


@dataclass(frozen=True)
class Part:
    """A regime or a frequency band.

    Attributes:
        name: its name.
        share: its share of the missing torque's weighted square beyond the smoother's own noise [1].
        of_time: its share of the time [1]; of the noise's square for a band.
        p: probability of so much by chance [1].
        low: lower edge of a band [Hz].
        high: upper edge of a band [Hz].
    """

    name: str
    share: float
    of_time: float
    p: float
    low: float | None = None
    high: float | None = None


def regimes(
    time: np.ndarray,
    speed: np.ndarray,
    still: np.ndarray,
    command: np.ndarray,
    top: float,
    nothing: float,
    limits: RegimeSettings,
) -> np.ndarray:
    """Regime of every sample.

    Args:
        time: times (time,) [s].
        speed: speed of the body (time,) [rad/s].
        still: whether the body is at rest (time,) [1].
        command: the command (time,) [V, 1, A, N m or rad].
        top: the largest command of all logs [as the command].
        nothing: the largest command that counts as none [as the command].
        limits: what counts as rest, as breaking away and so on.

    Returns:
        Index into `REGIMES` (time,) [1].
    """
    n = len(time)
    edge = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    rest, away, turn = np.zeros(n, bool), np.zeros(n, bool), np.zeros(n, bool)
    for begin, end in zip(edge[::2], edge[1::2], strict=True):
        if time[end - 1] - time[begin] >= limits.rest or begin == 0:
            rest[begin:end] = True
            if end < n:
                away |= (time >= time[end]) & (time < time[end] + limits.after_rest)
    for k in np.flatnonzero(np.diff(np.sign(speed)) != 0):
        if not rest[max(k - 1, 0) : k + 2].any():
            turn |= np.abs(time - time[k]) <= limits.around_turn
    size = np.abs(command)
    coasts = size <= nothing
    return np.select([rest, away, turn, ~coasts & (size >= limits.saturated * top), coasts], range(5), default=5)


def weights(deviation: np.ndarray) -> np.ndarray:
    """Weights of a log's missing torque: its inverse variance, bounded where the smoother is surest.

    Args:
        deviation: standard deviation of the missing torque (time,) [N m].

    Returns:
        Weights (time,) [1/(N m)²].
    """
    return 1.0 / np.maximum(deviation, 0.1 * np.median(deviation) + 1e-300) ** 2


def shares(
    mass: list[np.ndarray],
    own: list[np.ndarray],
    label: list[np.ndarray],
    own_label: list[np.ndarray],
    shifts: int,
) -> list[Part]:
    """Share of every regime in the weighted square of the missing torque, beyond that of the rig's own noise.

    For the probability by chance, the regimes of each log are shifted in time by more than the correlation time, so that runs of a
    regime stay whole.

    Args:
        mass: weighted square of each log (time,) [1].
        own: the same of draws of the rig's own noise (time, draws) [1].
        label: regimes of each log (time,) [1].
        own_label: regimes of the draws (time, draws) [1].
        shifts: how many random shifts tell what chance gives.

    Returns:
        The regimes that occur, the one with the largest share first.
    """
    found = []
    every, drawn = np.concatenate(label), np.concatenate([o.ravel() for o in own_label])
    drawn_mass = np.concatenate([m.ravel() for m in own])
    level = np.array(
        [np.mean(drawn_mass[drawn == r]) if np.any(drawn == r) else np.mean(drawn_mass) for r in range(len(REGIMES))]
    )
    beyond = [m - level[k] for m, k in zip(mass, label, strict=True)]
    sums = np.array(
        [sum(float(np.sum(b[k == r])) for b, k in zip(beyond, label, strict=True)) for r in range(len(REGIMES))]
    )
    total = float(np.sum(np.maximum(sums, 0.0)))
    rng = np.random.default_rng(0)
    random = [_shifts(b, rng, shifts) for b in beyond]
    for r, name in enumerate(REGIMES):
        if not np.any(every == r):
            continue
        chance = np.zeros(shifts)
        for b, k, s in zip(beyond, label, random, strict=True):
            turned = np.fft.irfft(np.fft.rfft(b) * np.conj(np.fft.rfft((k == r).astype(float))), len(b))
            chance += turned[s]
        p = (1.0 + np.sum(chance >= sums[r] - 1e-9 * abs(sums[r]))) / (1.0 + shifts)
        share = max(float(sums[r]), 0.0) / total if total > 0.0 else 0.0
        found.append(Part(name, share, float(np.mean(every == r)), float(p)))
    return sorted(found, key=lambda part: -part.share)


def _shifts(series: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    """Random shifts of a log by at least its correlation time either way."""
    n = len(series)
    least = int(min(np.ceil(correlation_time(series - np.mean(series))), n // 4))
    return rng.integers(least, n - least + 1, count) % n


def bands(power: OctavePower) -> list[Part]:
    """Share of every octave in the missing torque's power beyond that of draws of the rig's own noise.

    Args:
        power: power of the missing torque and of the draws by octave.

    Returns:
        The octaves, the lowest one first.
    """
    expected, beyond = power.expected, power.beyond
    total = max(float(np.sum(beyond)), 1e-300)
    return [
        Part(
            f"{low:.2g} to {high:.2g} Hz",
            float(beyond[k] / total),
            float(expected[k] / max(np.sum(expected), 1e-300)),
            above(float(power.power[k, 0]), power.power[k, 1:]),
            float(low),
            float(high),
        )
        for k, (low, high) in enumerate(zip(power.edges[:-1], power.edges[1:], strict=True))
        if expected[k] > 0.0
    ]
