"""The interface of every plant: all that the simulation asks of a rig, whatever its kind."""

from abc import abstractmethod
from collections.abc import Callable
from typing import NamedTuple, Protocol, runtime_checkable

from jaxtyping import Array, Float, Int

from rwjax.effects.part import Part, static
from rwjax.plant.structure import State, Structure
from rwjax.types import Scalar

Command = Float[Array, "*channels"]
"""What acts on a plant [V]: one voltage `()`, or one for each axis of a rig with two `(2,)`."""


class BodyTorque(NamedTuple):
    """Torque on one body that carries dry friction.

    Attributes:
        free: Torque on the body but for its own dry friction [N m].
        excess: What `free` exceeds the breakaway level by [N m]; 0 where the friction can hold the body.
    """

    free: Scalar
    excess: Scalar


class FrictionRates(NamedTuple):
    """Rates of a plant with dry friction.

    Attributes:
        rates: Rate of every state, in the state's unit per second.
        torques: One for each body that carries dry friction.
    """

    rates: State
    torques: list[BodyTorque]


class SmoothStep(NamedTuple):
    """A step as the equations of sliding bodies leave it: no body has been stopped or held yet.

    Attributes:
        t: Time at which the step begins [s].
        before: State at its beginning.
        after: State at its end.
        u: Voltage over the step [V], `()` or `(2,)`.
        h: Length of the step [s].
        rates: Rates of the state at its beginning, dry friction included.
        torques: For each body with dry friction its torque at the beginning and at the end of the step.
        sliding: Index in the state of a rate whose body slides whatever its speed, None where there is none.
    """

    t: Scalar
    before: State
    after: State
    u: Command
    h: Scalar
    rates: State
    torques: list[tuple[BodyTorque, BodyTorque]]
    sliding: int | None = None


class Followed(NamedTuple):
    """A voltage that follows a command over time.

    Attributes:
        mean: Its mean over every step `(s,)` [V].
        at: Its mean over a span of time [V]. Arguments are the number of the step in which the span begins, the command's mean from the step's
            beginning up to the span, and over the span [V], the time between both beginnings, and the span [s].
    """

    mean: Float[Array, " steps"]
    at: Callable[[Int[Array, ""], Scalar, Scalar, Scalar, Scalar], Scalar]


@runtime_checkable
class Drive(Protocol):
    """What lies between one command and one motor."""

    def act(self, command: Scalar) -> Scalar:
        """Voltage that acts for a command, before any delay.

        Args:
            command: Command before the drive [V].

        Returns:
            Voltage at the motor [V].
        """
        ...

    def follow(self, command: Float[Array, " steps"], h: Scalar) -> Followed:
        """What lags and rate limits of the drive make of the voltage.

        Args:
            command: Voltage over every step `(s,)` [V].
            h: Length of a step [s].

        Returns:
            The voltage that follows it.
        """
        ...

    @property
    def filters(self) -> bool:
        """Whether the voltage follows the command over time."""
        ...

    def delay(self) -> Scalar | None:
        """Time by which commands act late.

        Returns:
            The time [s], or None where no effect delays them.
        """
        ...


class Plant(Part):
    """A rig's equations of motion with its effects; the numbers are leaves, the structure is static."""

    structure: Structure = static()

    @abstractmethod
    def field(self, t: Scalar, x: State, u: Command) -> State:
        """Rates of the state without dry friction.

        Args:
            t: Time since the run's first sample [s].
            x: State, in the order of `structure.states`.
            u: Voltage at the motors [V], `()` or `(2,)`.

        Returns:
            Rate of every state, in the state's unit per second.
        """

    @abstractmethod
    def with_friction(self, t: Scalar, x: State, u: Command, start: State, begun: State | None = None) -> FrictionRates:
        """Rates of the state with dry friction, and the torque on every body that carries any.

        A sliding body feels its level against the direction in which it slides. A resting body feels exactly what keeps
        it at rest, up to its breakaway level.

        Args:
            t: Time since the run's first sample [s].
            x: State.
            u: Voltage at the motors [V], `()` or `(2,)`.
            start: State whose rates give the directions of sliding: the one at the beginning of the step.
            begun: State at the beginning of a step that ends at `x`: the torque of a contact is then such that the mean of both ends
                is that over the step.

        Returns:
            The rates and the torques.
        """

    @abstractmethod
    def with_smooth_friction(self, t: Scalar, x: State, u: Command, width: Scalar) -> State:
        r"""Rates of the state with dry friction by a smooth sign, $\tanh(w/\text{width})$.

        They are continuous in the state. A body that friction would hold creeps: a torque $\tau$ below its level $M$ moves it at
        $\text{width}\,\operatorname{artanh}(\tau/M)$.

        Args:
            t: Time since the run's first sample [s].
            x: State.
            u: Voltage at the motors [V], `()` or `(2,)`.
            width: Rate at which 76 % of the friction acts [rad/s].

        Returns:
            Rate of every state, in the state's unit per second.
        """

    @abstractmethod
    def settle(self, step: SmoothStep) -> State:
        """State at the end of a step, with bodies held that rested and stopped or turned whose speed changed sign.

        Args:
            step: The step as the equations of sliding bodies leave it.

        Returns:
            State at the step's end.
        """

    @abstractmethod
    def deflected(self, before: State, after: State, h: Scalar) -> State:
        """State after a step with the deflection of elastic friction that follows from the angle turned, and with the time at rest.

        Args:
            before: State at the step's beginning.
            after: State at the step's end.
            h: Length of the step [s].

        Returns:
            State at the step's end.
        """

    @abstractmethod
    def within_limits(self, x: State) -> State:
        """State with every current within what its driver allows.

        Args:
            x: State.

        Returns:
            The same state with its currents clipped.
        """

    @abstractmethod
    def no_command(self) -> Command:
        """Voltages of a rig that is given no command.

        Returns:
            0 V for each motor, `()` or `(2,)` [V].
        """

    @abstractmethod
    def act(self, command: Command) -> Command:
        """Voltages that act for commands, before any delay.

        Args:
            command: Command before the drive [V], `()` or `(2,)`.

        Returns:
            Voltage at the motors [V], of the same shape.
        """

    @abstractmethod
    def channels(self, command: Float[Array, "k *channels"]) -> list[tuple[Drive, Float[Array, " k"]]]:
        """Each drive with its command.

        Args:
            command: Samples of the command [V], `(k,)` or `(k, 2)`.

        Returns:
            Each drive, in the order of the commands, and the samples of its command `(k,)` [V].
        """

    @abstractmethod
    def pace(self) -> Scalar | float:
        """Pace of the logger's clock.

        Returns:
            Seconds that pass in one second of the log [1].
        """

    @abstractmethod
    def age(self) -> Scalar | None:
        """Age of what the axes' encoders read.

        Returns:
            The age [s], or None where no effect makes readings late.
        """

    @abstractmethod
    def outputs(self, t: Scalar, x: State, u: Command, seen: State | None = None) -> tuple[Scalar, ...]:
        """Readings in SI, in the order of `structure.outputs`.

        Args:
            t: Time since the run's first sample [s].
            x: State.
            u: Voltage at the motors [V], `()` or `(2,)`.
            seen: State that the axes' encoders read, where they are late.

        Returns:
            One reading for each output [rad, rad/s or A].
        """
