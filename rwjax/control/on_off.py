"""The ideal on-off slew in closed form: full torque, a hold at the wheel's top rate, full torque the other way."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from rwjax.control.controller import wheel_holding_voltage
from rwjax.rig.model import Rig


class OnOff(NamedTuple):
    """The ideal law: the wheel speeds up, keeps its rate and slows down.

    Attributes:
        acceleration: Acceleration of the wheel [rad/s²].
        ramp: Time in which it speeds up, and in which it slows down [s].
        hold: Time in which it keeps its rate [s].
        top: Rate that it keeps [rad/s].

    Source:
        Thesis, eq. 4.2 to 4.6.
    """

    acceleration: float
    ramp: float
    hold: float
    top: float

    @property
    def time(self) -> float:
        """Duration of the whole [s]."""
        return 2.0 * self.ramp + self.hold

    def wheel(self, t: Float[np.ndarray, " t"]) -> Float[np.ndarray, " t"]:
        """Rate of the wheel.

        Args:
            t: Times [s], `(t,)`.

        Returns:
            Wheel rate [rad/s], `(t,)`.
        """
        return self.acceleration * np.minimum(np.clip(t, 0.0, self.ramp), np.clip(self.time - t, 0.0, self.ramp))

    def turned(self, t: Float[np.ndarray, " t"]) -> Float[np.ndarray, " t"]:
        """Angle through which the wheel has turned; the axis turns J/I times as far the other way (thesis, eq. 4.2).

        Args:
            t: Times [s], `(t,)`.

        Returns:
            Angle of the wheel [rad], `(t,)`.
        """
        up, down = np.clip(t, 0.0, self.ramp), np.clip(t - self.ramp - self.hold, 0.0, self.ramp)
        flat = np.clip(t - self.ramp, 0.0, self.hold + self.ramp)
        return self.acceleration * (0.5 * up**2 + self.ramp * flat - 0.5 * down**2)


def on_off(I: float, J: float, angle: float, torque: float, top: float) -> OnOff:
    r"""Ideal on-off slew of an axis without friction.

    $t_1 = J\Omega/\tau$, $t_2 = \theta I/(J\Omega) - t_1$. Where $t_2$ is negative the wheel turns round before its top rate,
    at $\Omega = \sqrt{\theta I \tau}/J$.

    Args:
        I: Inertia of the axis [kg m²].
        J: Inertia of the wheel [kg m²].
        angle: Angle to turn [rad].
        torque: Torque of the motor [N m].
        top: Top rate of the wheel [rad/s].

    Returns:
        The law.

    Source:
        Thesis, eq. 4.3 to 4.6.
    """
    size = abs(angle)
    peak = min(top, np.sqrt(size * I * torque) / J)
    ramp = J * peak / torque
    return OnOff(torque / J, ramp, max(size * I / (J * peak) - ramp, 0.0), peak)


def on_off_voltage(rig: Rig, ideal: OnOff, t: Float[np.ndarray, " t"]) -> Float[np.ndarray, " t"]:
    r"""Voltage that makes the wheel follow the ideal law, $V = R\,(J\dot\Omega + b\,\Omega)/K + K\,\Omega$, inductance left out.

    Args:
        rig: The rig.
        ideal: The law.
        t: Times [s], `(t,)`.

    Returns:
        Voltage [V], `(t,)`.
    """
    K, R, J = (rig.values[n] for n in ("motor.torque_constant", "motor.resistance", "wheel.inertia"))
    rising = np.where(
        t < ideal.ramp, 1.0, np.where(t < ideal.ramp + ideal.hold, 0.0, np.where(t < ideal.time, -1.0, 0.0))
    )
    return R / K * J * ideal.acceleration * rising + wheel_holding_voltage(rig.values) * ideal.wheel(t)
