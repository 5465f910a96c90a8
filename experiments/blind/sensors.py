"""From the states of a run to the columns of its log: encoder errors, late readings, clock, noise, counts."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.signal import lfilter

from experiments.blind.simulator import STEP, Truth, missed_rate, run
from experiments.blind.truth import LOST, OMEGA, PSI, THETA, W

FRICTION = ("viscous", "coulomb", "excess", "b", "wheel_coulomb")


@dataclass(frozen=True)
class Sensors:
    """What a rig logs: standard deviation of the noise of each column, counts per turn of those in counts."""

    noise: dict[str, float]
    counts: dict[str, int] = field(default_factory=dict)
    colour: float = 0.0  # correlation of the noise of one sample with that of the next

    def floor(self) -> dict[str, float]:
        """What noise and quantisation leave of each column, in SI."""
        step = {name: 2 * np.pi / n for name, n in self.counts.items()}
        return {name: float(np.hypot(s, step.get(name, 0.0) / np.sqrt(12.0))) for name, s in self.noise.items()}


@dataclass(frozen=True)
class Recorded:
    """Inputs of one run: times stamped, commands, times of the samples by the same clock, start, what is its own alone."""

    time: np.ndarray
    command: np.ndarray
    at: np.ndarray
    start: np.ndarray  # psi, w, theta, omega, i
    salt: float = 0.0  # of its random events
    friction: float = 1.0  # factor on all friction
    rumble: float = 0.0  # N m, RMS of the coloured noise of the torque


def of_run(truth: Truth, record: Recorded) -> Truth:
    """The rig as it is in one run."""
    own = {name: record.friction * getattr(truth, name) for name in FRICTION}
    return replace(truth, salt=record.salt, rumble=record.rumble, **own)


def readings(truth: Truth, record: Recorded, columns, step: float = STEP) -> dict[str, np.ndarray]:
    """What each of `columns` would hold without noise and quantisation, in SI."""
    pace = float(np.exp(-truth.clock))  # seconds in one second of the logger
    p = of_run(truth, record).array()
    at = record.at * pace
    times = at if truth.sensor_delay == 0.0 else np.union1d(at, np.maximum(at - truth.sensor_delay, at[0]))
    states = run(record.time * pace, record.command, times, record.start, p, step)
    now = states[np.searchsorted(times, at)]
    late = states[np.searchsorted(times, np.maximum(at - truth.sensor_delay, at[0]))]
    wheel = truth.kind == 0
    angle, rate = encoder(truth, late[:, THETA if wheel else PSI], late[:, OMEGA if wheel else W], late[:, LOST], p)
    angle = angle + truth.jump * (at > truth.jump_time + 0.7 * record.salt)
    found = {"current_A": now[:, -1], "wheel_counts": now[:, THETA], "wheel_rad_s": now[:, OMEGA]}
    found |= (
        {"wheel_counts": angle, "wheel_rad_s": rate}
        if wheel
        else {"yaw_counts": angle, "yaw_rad": angle, "yaw_rad_s": rate}
    )
    return {name: found[name] for name in columns}


def encoder(truth: Truth, angle, rate, lost, p) -> tuple[np.ndarray, np.ndarray]:
    """Angle and rate as an encoder with errors reads them."""
    e, phase, second = truth.eccentricity, truth.eccentricity_phase, truth.eccentricity_2
    bend = e * (np.sin(angle + phase) + second * np.sin(2.0 * (angle + phase)))
    slope = 1.0 + e * (np.cos(angle + phase) + 2.0 * second * np.cos(2.0 * (angle + phase)))
    factor = float(np.exp(truth.scale))
    behind = np.array([missed_rate(w, p) for w in rate]) if truth.missed else 0.0
    return factor * (angle - lost + bend), factor * (rate - behind) * slope


DIGITS = {"yaw_rad": 5, "yaw_rad_s": 4, "wheel_rad_s": 2, "current_A": 3}


def coloured(count: int, colour: float, rng: np.random.Generator) -> np.ndarray:
    """Noise of standard deviation 1, of which neighbours correlate by `colour`."""
    white = rng.standard_normal(count)
    if colour == 0.0:
        return white
    driven = np.sqrt(1.0 - colour**2) * white
    driven[:1] = white[:1]
    return lfilter([1.0], [1.0, -colour], driven)


def cells(clean: dict[str, np.ndarray], sensors: Sensors, rng: np.random.Generator) -> dict[str, list[str]]:
    """Cells of each column: rounded to counts, or with noise added."""
    columns = {}
    for name, y in clean.items():
        noisy = y + sensors.noise[name] * coloured(len(y), sensors.colour, rng)
        if name in sensors.counts:
            columns[name] = [str(c) for c in np.round(noisy * sensors.counts[name] / (2 * np.pi)).astype(int)]
        else:
            columns[name] = [f"{v:.{DIGITS[name]}f}" for v in noisy]
    return columns
