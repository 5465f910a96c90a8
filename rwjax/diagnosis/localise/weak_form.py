r"""Weak form of an acceleration: test functions by which no reading has to be differentiated.

With test functions $\varphi$ that vanish at both ends of their support,
$\int\varphi\,\dot w = -\int\dot\varphi\,w = \int\ddot\varphi\,\psi$ (Messenger and Bortz, Multiscale Model. Simul. 19 (2021)).
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from rwjax.diagnosis.localise.body_motion import Read


def bump(s: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Test function of unit area with first and second derivative by time.

    It is proportional to $(1 - s^2)^5$.

    Args:
        s: place in the support, from -1 to 1 (m,) [1].
        length: length of the support [s].

    Returns:
        The function [1/s], its first [1/s²] and its second derivative [1/s³], each (m,).
    """
    inside = np.maximum(1.0 - s * s, 0.0)
    cube = inside * inside * inside
    scale, ds = 693.0 / 256.0 / length, 2.0 / length
    value, first = cube * inside * inside, -10.0 * s * cube * inside
    return scale * value, scale * ds * first, scale * ds**2 * (80.0 * s * s - 10.0 * inside) * cube


@dataclass(frozen=True)
class WeakForm:
    """Test functions of one log times the weights of the trapezoidal rule.

    Attributes:
        by_order: the test functions (m, time), their first and their second derivative.
    """

    by_order: tuple[csr_array, csr_array, csr_array]

    @classmethod
    def of(cls, time: np.ndarray, length: float) -> "WeakForm":
        """Test functions of a length that overlap by half.

        Args:
            time: the log's times (time,) [s].
            length: length of a test function's support [s].

        Returns:
            The test functions with the weights of the log's times.
        """
        centres = np.arange(time[0] + 0.5 * length, time[-1] - 0.5 * length, 0.5 * length)
        first = np.searchsorted(time, centres - 0.5 * length)
        last = np.searchsorted(time, centres + 0.5 * length, side="right")
        rows = np.repeat(np.arange(len(centres)), last - first)
        columns = np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)])
        dt = np.diff(time)
        weight = 0.5 * (np.append(dt, 0.0) + np.append(0.0, dt))[columns]
        shape = (len(centres), len(time))
        orders = bump(2.0 * (time[columns] - centres[rows]) / length, length)
        value, slope, curvature = (csr_array((weight * f, (rows, columns)), shape=shape) for f in orders)
        return cls((value, slope, curvature))

    def acceleration(self, read: Read, columns: slice) -> np.ndarray:
        r"""Weak acceleration $\int\varphi\,\dot w$ of a body's readings.

        Args:
            read: the body's motion; smoothed values stand in for missing readings.
            columns: readings to use, the log's own (0) or draws.

        Returns:
            Acceleration under each test function (m, columns) [rad/s²].
        """
        y = read.readings[:, columns]
        y = np.where(np.isfinite(y), y, read.states[:, 0, columns])
        y = y - y[:1]
        return self.by_order[2] @ y if read.is_angle else -(self.by_order[1] @ y)

    def noise(self, read: Read, noise: float) -> np.ndarray:
        """Standard deviation that white noise gives the weak acceleration.

        Args:
            read: the body's motion.
            noise: standard deviation of a reading [rad] or [rad/s].

        Returns:
            Standard deviation under each test function (m,) [rad/s²].
        """
        return noise * np.sqrt(self.by_order[2 if read.is_angle else 1].power(2).sum(axis=1))
