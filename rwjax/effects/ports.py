"""Ports: the places of the plant where an effect may act. Every effect is a final class on exactly one of them.

command u -> `CommandMap` -> `CommandDelay` -> motor -> `WheelDry` -> `AxisTorque`, `AxisDry` -> encoder.
"""

from abc import abstractmethod
from typing import ClassVar, NamedTuple

import equinox as eqx

from rwjax.types import Scalar


class Motion(NamedTuple):
    """What an effect may depend on. States that a kind of rig does not have are 0.

    `t` [s] since the run's first sample, `u` command after the drive [V], `psi` [rad], `w` [rad/s] of the axis,
    `theta` [rad], `Omega` [rad/s] of the wheel, `i` [A].
    """

    t: Scalar
    u: Scalar
    psi: Scalar
    w: Scalar
    theta: Scalar
    Omega: Scalar
    i: Scalar


class Effect(eqx.Module):
    """A part that a plant may have: equation, source, parameters, null value, name and label in one class."""

    name: ClassVar[str]
    label: ClassVar[str]
    coordinate: ClassVar[str]
    """What the missing part is a function of, in the words of `diagnosis.json`."""


class AxisTorque(Effect):
    """Torque on the axis that is smooth in the motion."""

    @abstractmethod
    def torque(self, motion: Motion) -> Scalar:
        """Torque acting on the axis [N m]; positive speeds up positive rotation."""


class AxisDry(Effect):
    """Dry friction of the axis: opposes sliding, and holds a resting axis up to its level."""

    @abstractmethod
    def level(self, motion: Motion, direction: float) -> Scalar:
        """Level of the friction [N m] while sliding towards `direction` (+1 or -1); at `w = 0` the breakaway level."""


class WheelDry(Effect):
    """Dry friction between wheel and body."""

    @abstractmethod
    def level(self, motion: Motion, direction: float) -> Scalar:
        """Level of the friction [N m] while the wheel turns towards `direction` (+1 or -1)."""


class CommandMap(Effect):
    """Static map of the command before it becomes voltage or torque."""

    @abstractmethod
    def command(self, u: Scalar) -> Scalar:
        """Voltage that acts [V] for the command `u` [V]."""


class CommandDelay(Effect):
    """Pure delay of the command."""

    @abstractmethod
    def delay(self) -> Scalar:
        """Time by which the command acts late [s]."""
