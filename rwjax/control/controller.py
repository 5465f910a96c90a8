"""The controller of an axis: its law with gains and limits, and the timing with which it samples and acts."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from rwjax.rig.model import Rig
from rwjax.types import Scalar

LEAST_STEPS = 4
"""Time steps of the plant in a period of the controller, at least."""
LONGEST_STEP = 2.5e-3
"""Longest time step of the plant [s]."""
FILTER_TIME = 0.02
"""Time constant of the derivative's filter where none is given [s]."""


class Controller(NamedTuple):
    r"""PID law with friction feed-forward, $u = K_p e + K_i \int e + K_d \dot e + u_f\,\mathrm{sgn}\,e$, clipped.

    The integral stands still while the command is clipped or held and the error drives it further. Every entry may be an
    array under `jax.vmap`.

    Attributes:
        kp: Proportional gain [V/rad].
        ki: Integral gain [V/(rad s)].
        kd: Derivative gain [V s/rad].
        filter_time: Time constant of the derivative's filter [s].
        feedforward: Command that overcomes dry friction, $u_f$ [V].
        deadband: Error within which nothing is fed forward [rad].
        voltage_limit: Largest command [V].
        wheel_rate_limit: Wheel rate [rad/s] from which on a command that drives the wheel further is held to what keeps
            its rate.
    """

    kp: Scalar | float
    ki: Scalar | float = 0.0
    kd: Scalar | float = 0.0
    filter_time: Scalar | float = 0.0
    feedforward: Scalar | float = 0.0
    deadband: Scalar | float = 0.0
    voltage_limit: Scalar | float = np.inf
    wheel_rate_limit: Scalar | float = np.inf


DEFAULT_CONTROLLER = Controller(0.0, filter_time=FILTER_TIME, deadband=math.radians(0.2), voltage_limit=10.0)
"""Limits and filter of a controller whose gains are looked for."""


class LoopTiming(NamedTuple):
    """When a sampled controller reads and acts, and with which resolution. Static: it decides the shape of the computation.

    Attributes:
        period: Sampling period of the controller [s].
        steps: Time steps of the plant in one period [1].
        delay_steps: Delay from a reading to its command, in time steps of the plant [1]. A part of a step is allowed, and
            more than a period too.
        counts: Counts per turn of the encoder [1]; 0 where the controller reads the angle itself.
    """

    period: float = 0.01
    steps: int = 4
    delay_steps: float = 0.0
    counts: int = 0

    @property
    def delay(self) -> float:
        """Delay from a reading to its command [s]."""
        return self.delay_steps * self.period / self.steps

    @property
    def delay_parts(self) -> tuple[int, float]:
        """Whole periods in the delay [1], and the rest of it in time steps of the plant [1]."""
        return split_delay(self.delay_steps, float(self.steps))

    def with_extra_delay(self, time: float) -> "LoopTiming":
        """The timing with a longer delay.

        Args:
            time: What comes on top of the delay [s].

        Returns:
            The same timing, its commands `time` later.
        """
        return self._replace(delay_steps=self.delay_steps + time * self.steps / self.period)


DEFAULT_TIMING = LoopTiming()
"""100 Hz without delay, four time steps of the plant in a period, the angle read without rounding."""


def split_delay(delay: float, period: float) -> tuple[int, float]:
    """Whole periods in a delay, and the rest.

    Args:
        delay: Delay [s], or in time steps [1].
        period: Period [s], or in time steps [1].

    Returns:
        Number of whole periods [1], and the rest of the delay [s], or in time steps [1].
    """
    whole = int(delay / period + 1e-9)
    return whole, max(delay - whole * period, 0.0)


def wheel_holding_voltage(numbers: Mapping[str, Scalar | float]) -> Scalar | float:
    r"""Voltage per wheel rate that keeps a wheel turning, $K + R\,b/K$ [V s/rad].

    It balances the back-EMF and the motor's viscous friction.

    Args:
        numbers: Numbers of the plant by name: `motor.torque_constant` K [N m/A], `motor.resistance` R [ohm] and, where
            there is one, `motor.friction` b [N m s/rad].

    Returns:
        Voltage over wheel rate [V s/rad].
    """
    K, R = numbers["motor.torque_constant"], numbers["motor.resistance"]
    return K + R * numbers.get("motor.friction", 0.0) / K


def loop_timing(rig: Rig, period: float = 0.01, delay: float = 0.0) -> LoopTiming:
    """Timing of a controller that reads a rig's own encoder.

    Args:
        rig: The rig, of which the encoder of the axis counts; its own delays do not.
        period: Sampling period of the controller [s].
        delay: Time from a reading to its command [s].

    Returns:
        The timing, with at least `LEAST_STEPS` time steps of the plant in a period, none longer than `LONGEST_STEP`.
    """
    steps = max(LEAST_STEPS, math.ceil(period / LONGEST_STEP - 1e-9))
    return LoopTiming(period, steps, steps * delay / period, int(rig.counts_per_rev.get("axis", 0)))
