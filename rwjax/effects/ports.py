"""Ports: the places of the plant where an effect may act. Every effect is a final class on exactly one of them.

command u -> `CommandMap` -> `CommandDelay` -> `CommandFilter` -> `Supply` -> motor: `MotorTorque`, `CurrentLimit`, `Winding`
-> wheel: `WheelTorque`, `WheelDry` -> axis: `Coupling`, `AxisTorque`, `AxisDry`, `AxisAgeing`, `AxisElastic` -> `Inertia` -> encoder:
`Encoder` -> `EncoderDelay` -> log: `Reading`; `GoalDelay`, what a servo is told; and `Clock`, the logger's time. An effect may carry
states of its own, 0 when a run begins.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from rwjax.effects.effect import Effect, Motion
from rwjax.types import Scalar

SLIDING = 1e-6
"""Rate [rad/s] at which the slope of dry friction by the speed is taken where it has no slope at standstill itself."""


Advance = Callable[[tuple[Scalar, ...], Scalar], tuple[tuple[Scalar, ...], Scalar]]
"""One step of what follows a command: from its states and the command to its states then and the mean over the step [V]."""

Kept = tuple[Float[Array, " steps"], ...]
"""States of a command filter at the beginning of every step, each `(steps,)` [V]."""


class AxisTorque(Effect):
    """Torque on the axis that is smooth in the motion."""

    @abstractmethod
    def torque(self, motion: Motion) -> Scalar:
        """Torque acting on the axis [N m]; positive speeds up positive rotation.

        Args:
            motion: The motion.

        Returns:
            The torque [N m].
        """


class Dry(Effect):
    """Dry friction on a body: opposes sliding, and holds a resting body up to its level."""

    @abstractmethod
    def level(self, motion: Motion, direction: float) -> Scalar:
        """Level of the friction [N m] while sliding; at standstill the breakaway level.

        Args:
            motion: The motion.
            direction: +1 or -1, the direction of sliding [1].

        Returns:
            The level [N m]; what it adds to the level of other dry friction.
        """

    def steep(self) -> Bool[Array, ""]:
        """Whether its level is infinitely steep over the rate at standstill.

        Returns:
            True or False, an array `()`.
        """
        return jnp.zeros((), bool)

    def beside_standstill(self) -> "Dry":
        """Friction with the same slope of the level at standstill, which it approaches linearly with the rate.

        Returns:
            Such friction; itself where its own slope does so.
        """
        return self

    @classmethod
    def slope_note(cls, given: Mapping[str, float]) -> str:
        """What is said of the slope of its level at standstill where the linearised plant cannot hold it.

        Args:
            given: Its numbers by name (SI); one that is left out is at its null.

        Returns:
            The words, "" where the slope at standstill is that of small rates.
        """
        return ""


class AxisDry(Dry):
    """Dry friction of the axis."""

    def share(self, motion: Motion) -> Scalar | float:
        """Share by which it raises the level of all other dry friction of the axis [1].

        Args:
            motion: The motion.

        Returns:
            The share [1].
        """
        return 0.0


class AxisAgeing(AxisDry):
    """Dry friction of the axis that depends on how long it has rested, for the library's exact step alone.

    Its state is that time [s], 0 at the end of a step that begins in motion; other solvers leave it at 0.
    """

    states: ClassVar[tuple[str, ...]] = ("rest",)


class AxisElastic(Dry):
    """Dry friction of the axis that builds up over a displacement: all of it acts through this effect.

    Its states are the shares [1] of their levels that its elements have built up: 0 when nothing is bent, 1 or -1 when all
    slides forward or backward. Its `level` is what it adds to that of other friction.
    """

    linear_as: ClassVar[str | None] = ""

    @abstractmethod
    def built_up(self, shares: tuple[Scalar, ...]) -> Scalar:
        """Share of the whole level that is built up, positive against rotation forward.

        Args:
            shares: Those of its elements, in the order of `states` [1].

        Returns:
            The share, -1 to 1 [1].
        """

    @abstractmethod
    def damping(self, motion: Motion) -> Scalar:
        """Friction besides while the displacement changes [N m].

        Args:
            motion: The motion.

        Returns:
            The torque against the rate [N m].
        """

    @abstractmethod
    def rates(self, shares: tuple[Scalar, ...], w: Scalar) -> tuple[Scalar, ...]:
        """Rates at which the elements build up.

        Args:
            shares: Those of its elements, in the order of `states` [1].
            w: Rate of the axis [rad/s].

        Returns:
            The rates in the same order [1/s].
        """

    @abstractmethod
    def after(self, shares: tuple[Scalar, ...], travel: Scalar) -> tuple[Scalar, ...]:
        """What the elements have built up after the axis has turned.

        Args:
            shares: Those of its elements before, in the order of `states` [1].
            travel: The angle by which it turns [rad].

        Returns:
            The shares after, in the same order [1].
        """


class Coupling(Effect):
    """What lies between the drive's side of the axis and the axis itself; states: twist [rad] and slip [rad/s]."""

    states: ClassVar[tuple[str, ...]] = ("twist", "slip")

    @abstractmethod
    def share(self) -> Scalar:
        """Share of the inertia that lies on the drive's side [1].

        Returns:
            The share [1].
        """

    @abstractmethod
    def torque(self, motion: Motion) -> Scalar:
        """Torque that it transmits to the axis [N m].

        Args:
            motion: The motion.

        Returns:
            The torque [N m].
        """

    def mean_torque(self, before: Motion, after: Motion) -> Scalar:
        """Mean over a time step of the torque that it transmits [N m], where twist and slip change evenly over the step.

        Args:
            before: The motion as the step begins.
            after: The motion as it ends.

        Returns:
            The torque [N m].
        """
        return 0.5 * (self.torque(before) + self.torque(after))


class Inertia(Effect):
    """Inertia of the axis (of the wheel, where there is no axis) that changes with its rate."""

    @abstractmethod
    def factor(self, w: Scalar) -> Scalar:
        """Factor on the inertia [1]; 1 at standstill.

        Args:
            w: Rate of the body [rad/s].

        Returns:
            The factor [1].
        """


class WheelTorque(Effect):
    """Torque between body and wheel that is smooth in the motion."""

    @abstractmethod
    def torque(self, motion: Motion) -> Scalar:
        """Torque acting on the wheel [N m]; positive speeds up positive rotation.

        Args:
            motion: The motion.

        Returns:
            The torque [N m].
        """


class WheelDry(Dry):
    """Dry friction between wheel and body."""


class MotorTorque(Effect):
    """Torque per ampere that depends on the current."""

    @abstractmethod
    def factor(self, i: Scalar) -> Scalar:
        """Share of the torque constant that is left at a current [1].

        Args:
            i: Current [A].

        Returns:
            The share [1].
        """


class CurrentLimit(Effect):
    """Limit of the current."""

    @abstractmethod
    def limit(self) -> Scalar:
        """Largest current of either sign [A].

        Returns:
            The current [A].
        """


class Winding(Effect):
    """Resistance of the winding that changes."""

    @abstractmethod
    def resistance(self, motion: Motion) -> Scalar:
        """Factor on the resistance [1].

        Args:
            motion: The motion.

        Returns:
            The factor [1].
        """


class CommandMap(Effect):
    """Static map of the command before it becomes voltage or torque."""

    @abstractmethod
    def command(self, u: Scalar) -> Scalar:
        """Voltage that acts for a command [V].

        Args:
            u: Command [V].

        Returns:
            The voltage [V].
        """


class CommandDelay(Effect):
    """Pure delay of the command."""

    @abstractmethod
    def delay(self) -> Scalar:
        """Time by which the command acts late [s].

        Returns:
            The time [s].
        """


class CommandFilter(Effect):
    """What the drive makes of its command over time, whatever the rig does."""

    linear: ClassVar[bool] = False
    """Whether it is a row of first-order lags, which a transfer function holds."""

    filter_states: ClassVar[tuple[str, ...]]
    """Names of what it keeps from one step to the next, each a voltage [V]."""

    @abstractmethod
    def over(self, h: Scalar) -> "Advance":
        """What a step towards a held command does.

        Args:
            h: Length of the step [s].

        Returns:
            A function from its states at a step's beginning [V] and the command over the step [V] to its states at the
            step's end [V] and the mean voltage over the step [V].
        """

    def follow(self, command: Float[Array, " steps"], h: Scalar) -> tuple[Float[Array, " steps"], Kept]:
        """What it makes of a command; settled at the first step.

        Args:
            command: Command over each step [V] `(steps,)`.
            h: Length of a step [s].

        Returns:
            The mean voltage over each step [V] `(steps,)`, and its states at the beginning of each [V].
        """
        advance = self.over(h)

        def step(now: tuple[Scalar, ...], wanted: Scalar) -> tuple[tuple[Scalar, ...], Any]:
            end, mean = advance(now, wanted)
            return end, (mean, now)

        return jax.lax.scan(step, (command[0],) * len(self.filter_states), command)[1]

    @classmethod
    def order(cls, given: Mapping[str, Any]) -> int:
        """Number of first-order lags in a row that it is, where it is `linear`.

        Args:
            given: Its numbers by name (SI), each one number or an array of those of several plants `(…)`.

        Returns:
            The largest number of lags among the plants; 0 where it acts at once.
        """
        return 0

    def lags(self, order: int) -> tuple[Scalar, ...]:
        """Time constants of its lags [s], where it is `linear`.

        Args:
            order: Number of lags.

        Returns:
            The time constants [s], that of the lag next to the plant first.
        """
        return ()


class Supply(Effect):
    """What load takes away from the voltage."""

    @abstractmethod
    def voltage(self, u: Scalar, motion: Motion) -> Scalar:
        """Voltage at the motor [V].

        Args:
            u: Voltage of the drive [V].
            motion: The motion, without what load takes away.

        Returns:
            The voltage [V].
        """


class Encoder(Effect):
    """What the encoder of the axis (of the wheel, where there is no axis) reads of angle and rate."""

    @abstractmethod
    def read(self, angle: Scalar, rate: Scalar, motion: Motion) -> tuple[Scalar, Scalar]:
        """Angle [rad] and rate [rad/s] as read.

        Args:
            angle: The angle [rad].
            rate: The rate [rad/s].
            motion: The motion.

        Returns:
            The angle [rad] and the rate [rad/s] that the encoder reads.
        """


class EncoderDelay(Effect):
    """Lateness of what the encoder reads, its errors included; other sensors read at once."""

    longest: ClassVar[float]
    """Largest delay [s]: by so much do the windows of a fit overlap."""

    @abstractmethod
    def delay(self) -> Scalar:
        """Age of a reading [s].

        Returns:
            The age [s].
        """


class Reading(Effect):
    """What a sensor of any kind adds to its reading, an encoder's errors included."""

    @abstractmethod
    def read(self, output: str, value: Scalar) -> Scalar:
        """A reading as it is logged.

        Args:
            output: Name of the output on a rig with one axis.
            value: What the sensor measures [SI].

        Returns:
            The reading [SI].
        """


class GoalDelay(Effect):
    """Lateness of the goal of a servo, outside its loop."""

    needs_servo: ClassVar[bool] = True

    @abstractmethod
    def delay(self) -> Scalar:
        """Time by which the goal acts late [s].

        Returns:
            The time [s].
        """


class Clock(Effect):
    """Pace of the logger's clock."""

    @abstractmethod
    def pace(self) -> Scalar:
        """Seconds that pass in one second of the log [1].

        Returns:
            The pace [1].
        """
