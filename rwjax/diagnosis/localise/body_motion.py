"""Motion of one body as a log tells it: smoothed readings, and draws of what the fitted rig would have read."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.localise.own_noise import draws
from rwjax.diagnosis.localise.smoother import Smoother, smoother
from rwjax.diagnosis.settings import LocalisationSettings
from rwjax.fitting.multiple_shooting import Fit
from rwjax.logs.log import Log


@dataclass(frozen=True)
class Read:
    """One body's motion in one log.

    Attributes:
        name: the output that tells it.
        smoother: its smoother.
        readings: the reading, then draws of it (time, 1 + draws) [rad] or [rad/s].
        states: their smoothed states (time, a, 1 + draws).
    """

    name: str
    smoother: Smoother
    readings: np.ndarray
    states: np.ndarray

    @property
    def is_angle(self) -> bool:
        """Whether an angle is read, and not a rate."""
        return self.name in ("yaw_rad", "wheel_rad")

    def about_itself(self, fitted: Fit, log: Log, clean: np.ndarray, count: int, rng: np.random.Generator) -> "Read":
        """The reading, the smoothed motion without noise, the rig's own run without noise, and draws about the smoothed motion.

        Args:
            fitted: the fit.
            log: the log.
            clean: the rig's own run (time,) [rad] or [rad/s].
            count: how many draws.
            rng: the source of randomness.

        Returns:
            The motion with these columns.
        """
        path = self.states[:, 0, 0]
        drawn = np.concatenate([path[:, None], clean[:, None], draws(fitted, log, path, self.name, count, rng)], axis=1)
        gaps = np.isnan(self.readings[:, :1])
        states = np.concatenate([self.states[..., :1], self.smoother(np.where(gaps, np.nan, drawn))], axis=2)
        return Read(self.name, self.smoother, np.concatenate([self.readings[:, :1], drawn], axis=1), states)

    def position(self, time: np.ndarray) -> np.ndarray:
        """Smoothed angle [rad], from 0 where only the rate is read.

        Args:
            time: times (time,) [s].

        Returns:
            The angle (time, 1 + draws) [rad].
        """
        if self.is_angle:
            return self.states[:, 0]
        w, dt = self.states[:, 0], np.diff(time)[:, None]
        return np.concatenate([np.zeros((1, w.shape[1])), np.cumsum(0.5 * (w[1:] + w[:-1]) * dt, axis=0)])

    @property
    def rate(self) -> np.ndarray:
        """Smoothed speed (time, 1 + draws) [rad/s]."""
        return self.states[:, 1 if self.is_angle else 0]

    @property
    def acceleration(self) -> np.ndarray:
        """Smoothed acceleration (time, 1 + draws) [rad/s²]."""
        return self.states[:, 2 if self.is_angle else 1]

    @property
    def deviation(self) -> tuple[np.ndarray, np.ndarray]:
        """Standard deviations of speed [rad/s] and acceleration [rad/s²], each (time,)."""
        first = 1 if self.is_angle else 0
        return self.smoother.deviation[:, first], self.smoother.deviation[:, first + 1]


class Own(NamedTuple):
    """Draws of what the fitted rig would have read: its free run by output (time,) [SI], and how many draws."""

    clean: dict[str, np.ndarray]
    count: int


def read_body(fitted: Fit, number: int, body: str, limits: LocalisationSettings, own: Own | None = None) -> Read | None:
    """Motion of one body from a log and, if wanted, from draws of what the fitted rig would have read.

    Args:
        fitted: the fit of the rig as it is.
        number: number of the log.
        body: `yaw` or `wheel`.
        limits: limits of the smoother.
        own: the draws that are wanted.

    Returns:
        The motion, None where the log does not tell it.
    """
    noise, log = fitted.problem.noise, fitted.problem.logs[number]
    angle, rate = f"{body}_rad", f"{body}_rad_s"
    name = angle if angle in log.outputs else rate
    if name not in log.outputs:
        return None
    order = 3 if name == angle else 2
    smooth = smoother(log.outputs[name], np.diff(log.time), noise[name], order, limits.smoother)
    readings = log.outputs[name][:, None]
    if own is not None and own.count:
        rng = np.random.default_rng([number, body == "wheel"])
        drawn = draws(fitted, log, own.clean[name], name, own.count, rng)
        readings = np.concatenate([readings, drawn], axis=1)
    states = smooth(readings[:, :1])
    if readings.shape[1] > 1:
        gaps = np.isnan(readings[:, :1])
        states = np.concatenate([states, smooth(np.where(gaps, np.nan, readings[:, 1:]))], axis=2)
    return Read(name, smooth, readings, states)
