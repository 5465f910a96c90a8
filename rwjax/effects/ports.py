"""Ports: the places of the plant where an effect may act. Every effect is a final class on exactly one of them.

command u -> `CommandMap` -> `CommandDelay` -> `CommandFilter` -> `Supply` -> motor: `MotorTorque`, `CurrentLimit` -> wheel:
`WheelTorque`, `WheelDry` -> axis: `AxisTorque`, `AxisDry` -> encoder: `Encoder` -> `EncoderDelay`; and `Clock`, the logger's
time. An effect may carry states of its own, 0 when a run begins.
"""

from abc import abstractmethod
from typing import ClassVar, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from rwjax.types import Scalar


class Motion(NamedTuple):
    """What an effect may depend on. States that a kind of rig does not have are 0.

    `t` [s] since the run's first sample, `V` motor voltage, the command after the drive [V], `psi` [rad], `w` [rad/s] of the axis,
    `theta` [rad], `Omega` [rad/s] of the wheel, `i` [A], `load` torque [N m] that the drive transmits to the axis,
    `sensed` rate [rad/s] of what carries the encoder, `own` the effects' own states by `effect:state`.
    """

    t: Scalar
    V: Scalar
    psi: Scalar
    w: Scalar
    theta: Scalar
    Omega: Scalar
    i: Scalar
    load: Scalar
    sensed: Scalar
    own: dict[str, Scalar]


class Effect(eqx.Module):
    """A part that a plant may have: equation, source, parameters, null value, name and label in one class."""

    name: ClassVar[str]
    label: ClassVar[str]
    coordinate: ClassVar[str]
    """What the missing part is a function of, in the words of `diagnosis.json`."""
    group: ClassVar[str]
    """Effects of one group are compiled together where any of them is looked for, at their null if it is another."""
    at_angle: ClassVar[bool] = False
    """Whether it depends on where its body stands, not only on how far it turns: an unseen first angle then matters."""
    states: ClassVar[tuple[str, ...]] = ()
    """Names of its own states."""

    def mine(self, motion: Motion) -> tuple[Scalar, ...]:
        """Its own states in a motion."""
        return tuple(motion.own[f"{self.name}:{state}"] for state in self.states)

    def drift(self, motion: Motion) -> tuple[Scalar, ...]:
        """Rates of its own states."""
        return ()


class AxisTorque(Effect):
    """Torque on the axis that is smooth in the motion."""

    group: ClassVar[str] = "torque"

    @abstractmethod
    def torque(self, motion: Motion) -> Scalar:
        """Torque acting on the axis [N m]; positive speeds up positive rotation."""


class AxisDry(Effect):
    """Dry friction of the axis: opposes sliding, and holds a resting axis up to its level."""

    group: ClassVar[str] = "friction"

    @abstractmethod
    def level(self, motion: Motion, direction: float) -> Scalar:
        """Level of the friction [N m] while sliding towards `direction` (+1 or -1); at `w = 0` the breakaway level."""

    def share(self, motion: Motion) -> Scalar | float:
        """Share by which it raises the level of all other dry friction of the axis."""
        return 0.0


class WheelTorque(Effect):
    """Torque between body and wheel that is smooth in the motion."""

    group: ClassVar[str] = "motor"

    @abstractmethod
    def torque(self, motion: Motion) -> Scalar:
        """Torque acting on the wheel [N m]; positive speeds up positive rotation."""


class WheelDry(Effect):
    """Dry friction between wheel and body."""

    group: ClassVar[str] = "motor"

    @abstractmethod
    def level(self, motion: Motion, direction: float) -> Scalar:
        """Level of the friction [N m] while the wheel turns towards `direction` (+1 or -1)."""


class CommandMap(Effect):
    """Static map of the command before it becomes voltage or torque."""

    group: ClassVar[str] = "drive"

    @abstractmethod
    def command(self, u: Scalar) -> Scalar:
        """Voltage that acts [V] for the command `u` [V]."""


class CommandDelay(Effect):
    """Pure delay of the command."""

    group: ClassVar[str] = "drive"

    @abstractmethod
    def delay(self) -> Scalar:
        """Time by which the command acts late [s]."""


class CommandFilter(Effect):
    """What the drive makes of its command over time, whatever the rig does."""

    group: ClassVar[str] = "drive"

    @abstractmethod
    def follow(self, command: Float[Array, " steps"], h: Scalar) -> Float[Array, " steps"]:
        """Voltage over every step of length `h` [s] for the command over these steps [V]; settled at the first one."""


class Supply(Effect):
    """What load takes away from the voltage."""

    group: ClassVar[str] = "motor"

    @abstractmethod
    def voltage(self, u: Scalar, i: Scalar) -> Scalar:
        """Voltage at the motor [V] for the drive's `u` [V] while `i` [A] flows."""


class MotorTorque(Effect):
    """Torque per ampere that depends on the current."""

    group: ClassVar[str] = "motor"

    @abstractmethod
    def factor(self, i: Scalar) -> Scalar:
        """Share of the torque constant that is left at a current [A]."""


class CurrentLimit(Effect):
    """Limit of the current."""

    group: ClassVar[str] = "motor"

    @abstractmethod
    def limit(self) -> Scalar:
        """Largest current of either sign [A]."""


class Encoder(Effect):
    """What the encoder of the axis (of the wheel, where there is no axis) reads of angle and rate."""

    group: ClassVar[str] = "sensor"

    @abstractmethod
    def read(self, angle: Scalar, rate: Scalar, motion: Motion) -> tuple[Scalar, Scalar]:
        """Angle [rad] and rate [rad/s] as read."""


class EncoderDelay(Effect):
    """Lateness of what the encoder reads, its errors included; other sensors read at once."""

    group: ClassVar[str] = "sensor_delay"

    longest: ClassVar[float]
    """Largest delay [s]: by so much do the windows of a fit overlap."""

    @abstractmethod
    def delay(self) -> Scalar:
        """Age of a reading [s]."""


class Clock(Effect):
    """Pace of the logger's clock."""

    group: ClassVar[str] = "sensor"

    @abstractmethod
    def pace(self) -> Scalar:
        """Seconds that pass in one second of the log."""


class Winding(Effect):
    """Resistance of the winding that changes."""

    group: ClassVar[str] = "motor"

    @abstractmethod
    def resistance(self, motion: Motion) -> Scalar:
        """Factor on the resistance."""


class Coupling(Effect):
    """What lies between the drive's side of the axis and the axis itself; states: twist [rad] and slip [rad/s]."""

    states: ClassVar[tuple[str, ...]] = ("twist", "slip")

    @abstractmethod
    def share(self) -> Scalar:
        """Share of the inertia that lies on the drive's side."""

    @abstractmethod
    def torque(self, motion: Motion) -> Scalar:
        """Torque that it transmits to the axis [N m]."""


class AxisElastic(Effect):
    """Dry friction of the axis that builds up over a displacement: all of it acts through this effect. State: the share of
    the level that is built up."""

    states: ClassVar[tuple[str, ...]] = ("z",)

    @abstractmethod
    def level(self, motion: Motion, direction: float) -> Scalar:
        """What it adds to the level of the friction [N m] while sliding towards `direction`."""

    @abstractmethod
    def damping(self, motion: Motion) -> Scalar:
        """Friction besides [N m] while the displacement changes."""

    @abstractmethod
    def after(self, z: Scalar, travel: Scalar) -> Scalar:
        """The share after turning by `travel` [rad]."""
