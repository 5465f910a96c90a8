"""The base class of all effects: what an effect says about itself to the rest of the library."""

import math
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from rwjax.effects.part import Part
from rwjax.types import Scalar

COORDINATES = (
    "yaw_rate",
    "yaw",
    "pitch_rate",
    "pitch",
    "wheel_rate",
    "wheel_angle",
    "current",
    "voltage",
    "time",
    "load",
)
"""What a missing part may be a function of; pitch belongs to rigs with two axes, and `load` is any torque or the angle's scale."""


class Motion(NamedTuple):
    """What an effect may depend on. States that a kind of rig does not have are 0.

    Attributes:
        t: Time since the run's first sample [s].
        V: Motor voltage, the command after the drive [V].
        psi: Angle of the axis [rad].
        w: Rate of the axis [rad/s].
        theta: Angle of the wheel [rad].
        Omega: Rate of the wheel relative to the body [rad/s].
        i: Motor current [A].
        drawn: Power that the motor would draw from a supply without resistance [W]; V times 1 A where no current is known.
        load: Torque that the drive transmits to the axis [N m].
        sensed: Rate of the body that carries the encoder [rad/s].
        own: The effects' own states by `effect:state`.
    """

    t: Scalar
    V: Scalar
    psi: Scalar
    w: Scalar
    theta: Scalar
    Omega: Scalar
    i: Scalar
    drawn: Scalar
    load: Scalar
    sensed: Scalar
    own: dict[str, Scalar]


class FittedRig(NamedTuple):
    """A rig after a fit, as an effect needs it to say what it cannot be told from.

    Attributes:
        kind: Kind of the rig.
        names: Names of the effects that the fit holds: those of the rig file and those of the hypothesis.
        numbers: Values in SI by name, as fitted; none where the rig was not fitted.
    """

    kind: str
    names: frozenset[str]
    numbers: Mapping[str, float]


class Effect(Part):
    """A part that a plant may have. Its class holds everything that the library knows about it.

    The rest of the library asks these members and names no effect. Every effect sets name, label and coordinate. The
    other members have a value that suits most effects; an effect of the library also says its meaning and equation,
    for the tables of the docs.
    """

    name: ClassVar[str]
    """Name in rig files and diagnoses: the part where it acts, a dot, and what it is."""
    label: ClassVar[str]
    """Name in plots and reports."""
    coordinate: ClassVar[str]
    """What the missing part is a function of, in the words of `diagnosis.json`: one of `COORDINATES`."""
    meaning: ClassVar[str] = ""
    """What it is, for the table in the docs; "" for its label."""
    equation: ClassVar[str] = ""
    """Its equation as plain text without `|`, for the table in the docs."""

    at_angle: ClassVar[bool] = False
    """Whether it depends on where its body stands, not only on how far it turns: an unseen first angle then matters."""
    states: ClassVar[tuple[str, ...]] = ()
    """Names of its own states, each 0 at a run's first sample."""

    longest_step: ClassVar[float] = math.inf
    """Longest time step [s] that follows it; longer ones are divided."""
    light: ClassVar[bool] = False
    """Whether it costs next to nothing in a simulation, and at its nulls changes nothing: free runs of plants without it may then use
    the program of those with it (`rwjax.simulation.shared_program`)."""

    limits: ClassVar[tuple[str, ...]] = ()
    """Names of other effects that are a special case or a limit of it. A number that both have under one name means the same
    thing: a fit of one begins with the other's estimate."""
    covers: ClassVar[tuple[str, ...]] = ()
    """Numbers of the rig file of which any error is a special case of it."""
    includes: ClassVar[str] = ""
    """Name of the effect that it includes and that is a special case of it, or "". A number that both have is estimated
    only where neither the rig file nor another effect models the included one; else it is 0."""
    modelled_by: ClassVar[tuple[str, ...]] = ()
    """Numbers of the rig file each of which models it already: such a rig does not miss it."""
    like_larger: ClassVar[tuple[str, ...]] = ()
    """Numbers of the rig file that, fitted larger than the file says, cannot be told from it on any logs."""

    passes_for: ClassVar[tuple[str, ...]] = ()
    """Names of effects for which it passes, where it is a law outside the list of effects; none for an effect of the list."""

    output_of: ClassVar[Mapping[str, str]] = {}
    """The output on which a number acts alone, by the name that it has on a rig with one axis: a search estimates the number only
    where a log holds the output."""
    shown_above: ClassVar[Mapping[str, str]] = {}
    """Sizes (names of `rwjax.fitting.scales`) below which logs do not show a number for what it is: a search does not go there."""
    needs_servo: ClassVar[bool] = False
    """Whether it acts on the goal of a servo, which a rig without one does not have."""

    shown_by: ClassVar[Mapping[str, int]] = {}
    """The kinds of run that show it (keys of `rwjax.effects.shown.RUNS`), each with its rank in the list of that run: lower
    ranks come first, and equal ones in the order of the library."""
    ends_travel: ClassVar[bool] = False
    """Whether it ends the travel of the axis."""
    threshold: ClassVar[str] = ""
    """Its number that is the size of command [V] below which the drive gives nothing, or ""."""

    changes_over_time: ClassVar[bool] = False
    """Whether it changes with the time since the run began, whatever the rig does."""
    comes_and_goes: ClassVar[bool] = False
    """Whether it alternates about zero, so that a design by mean torques leaves it out."""
    mujoco_drops: ClassVar[Mapping[str, str]] = {}
    """Numbers that a MuJoCo model leaves out, each with what is then missing, in words."""
    linear_as: ClassVar[str | None] = None
    """Name of the effect that stands for it in the linearised plant: None for itself, "" for none."""
    linear_numbers: ClassVar[Mapping[str, float]] = {}
    """Numbers that it has in the linearised plant, where they are not its own."""

    @classmethod
    def same_as(cls, fitted: FittedRig) -> tuple[str, ...]:
        """Names of effects that are the same thing as this one on such a rig, whatever the logs.

        One of two such effects says so; the relation holds both ways.

        Args:
            fitted: The rig and its fit.

        Returns:
            Names of effects.
        """
        return ()

    @classmethod
    def largest_command(cls, given: Mapping[str, float]) -> float:
        """Size of the command beyond which more changes nothing [V].

        Args:
            given: Its numbers by name (SI).

        Returns:
            The size [V], infinite where there is none.
        """
        return math.inf

    @classmethod
    def travel(cls, given: Mapping[str, float]) -> float:
        """Angle that the axis can turn away from 0 either way [rad].

        Args:
            given: Its numbers by name (SI).

        Returns:
            The angle [rad], infinite where it sets none.
        """
        return math.inf

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        """What stands for it in the transfer function, as part of a sentence.

        Args:
            given: Its numbers by name (SI); empty for its numbers at their null.

        Returns:
            The words, "" where the transfer function holds the effect itself.
        """
        return ""

    @classmethod
    def c_level(cls, given: Mapping[str, float]) -> str:
        """Level of its friction of the axis as C code, over the rate's size `w` and its sign `s`.

        Args:
            given: Its numbers by name (SI).

        Returns:
            A C expression [N m], "" where it is no friction that the rate alone tells.
        """
        return ""

    @classmethod
    def c_command(cls, given: Mapping[str, float]) -> str:
        """How a command makes up for it, as C code that works on the command `u`.

        Args:
            given: Its numbers by name (SI).

        Returns:
            C statements that turn what is wanted behind it into what has to stand before it; "" where there are none.
        """
        return ""

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        """What it adds to a MuJoCo model, by the fields of `rwjax.export.mujoco_model`.

        Args:
            given: Its numbers by name (SI).

        Returns:
            Values by field [the field's unit]; None where MuJoCo has no such part.
        """
        return None

    @classmethod
    def from_mujoco(cls, fields: Mapping[str, float]) -> Mapping[str, float]:
        """Its numbers in a MuJoCo model, the inverse of `in_mujoco`.

        Args:
            fields: What a hinge and its actuator have, by the fields of `rwjax.export.mujoco_model` [the field's unit]. A field that is
                absent is 0, or no limit.

        Returns:
            Its numbers by name (SI); none where the model does not have it.
        """
        return {}

    @classmethod
    def state_names(cls) -> tuple[str, ...]:
        """Names that its own states have in a plant.

        Returns:
            The names in the order of `states`, as `axis.flexible_coupling:twist`.
        """
        return tuple(f"{cls.name}:{state}" for state in cls.states)

    def mine(self, motion: Motion) -> tuple[Scalar, ...]:
        """Its own states in a motion.

        Args:
            motion: The motion.

        Returns:
            The states in the order of `states` [each in its unit].
        """
        return tuple(motion.own[name] for name in self.state_names())

    def drift(self, motion: Motion) -> tuple[Scalar, ...]:
        """Rates of its own states.

        Args:
            motion: The motion.

        Returns:
            The rates in the order of `states` [each in its unit per second].
        """
        return ()
