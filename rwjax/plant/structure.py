"""What a plant is made of, without its numbers: kind, names, states, outputs and effects."""

import math
from collections.abc import Collection, Mapping
from functools import cache
from typing import NamedTuple

from rwjax.effects.library import BY_NAME, LIBRARY
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import CommandDelay, CommandFilter, EncoderDelay, WheelDry, WheelTorque
from rwjax.kinds import NUMBERS, SERVO, TWO_AXIS, WHEELED, half_column, of_half, on_half
from rwjax.types import Scalar

State = tuple[Scalar, ...]
"""One number for each state, in the order of `Structure.states`."""
Numbers = dict[str, Scalar]
"""Values by dotted name: `axis.inertia`, and `axis.stribeck.v_s` for parameters of effects."""

LONGEST_STEP = 5e-3
"""Longest time step [s] of a rig that is no joint; one may be 2 % longer (`rwjax.simulation.layout.NEARLY`). Where only angles are logged, faster samples share a step."""
OF_JOINTS, OF_INDUCTIVE_JOINTS = 2.5e-3, 1.25e-3
"""The same for joints, without and with inductance: a geared motor's own motion, I R/(N K)², settles within some 30 ms [s]."""
LATE_TICKS = 24
"""Ticks of a servo by which a delay within its loop is late at most."""
OUTPUTS = ("yaw_rad", "yaw_rad_s", "wheel_rad", "wheel_rad_s", "current_A")
"""What a rig with one axis and a wheel can read, in SI."""


class ServoStructure(NamedTuple):
    """What decides which program is compiled of the loop between a goal and what the drive is given.

    Attributes:
        damping_on: What its gain `kd` multiplies: the rate of the "error", or the "speed".
        period: Time between its ticks [s] in the rig file.
        period_off_by: Factor by which the plant's period may differ from it [1].
    """

    damping_on: str
    period: float
    period_off_by: float


class Structure(NamedTuple):
    """What decides which program is compiled: everything about a plant but its numbers.

    Attributes:
        kind: Kind of rig, one of `rwjax.kinds.KINDS`.
        numbers: Names of the base numbers.
        inductive: Whether the current is a state; without inductance it follows from the voltage at once.
        effects: Names of the effects, in the order of the library.
        command: What the drive is given: "voltage", "duty", "current" or "torque".
        servo: The loop that gives it, None where the logs hold the command itself.
        encoder_side: Side of a backlash or a coupling on which the axis's encoder sits: "link" or "motor".
        switched: Whether torque is off at times.
        unsigned: Outputs of which the device reports the size alone.
        tied: Numbers that follow from others, each with its formula (`rwjax.rig.tied`).
        read: Outputs that are worked out; all that the kind of rig has where none are named.
    """

    kind: str
    numbers: tuple[str, ...]
    inductive: bool
    effects: tuple[str, ...]
    command: str = "voltage"
    servo: "ServoStructure | None" = None
    encoder_side: str = "link"
    switched: bool = False
    unsigned: tuple[str, ...] = ()
    tied: tuple[tuple[str, str], ...] = ()
    read: tuple[str, ...] = ()

    @property
    def has_axis(self) -> bool:
        """Whether there is an axis in yaw."""
        return self.kind != "wheel"

    @property
    def has_wheel(self) -> bool:
        """Whether there is a motor with a wheel."""
        return self.kind in (*WHEELED, *TWO_AXIS)

    @property
    def has_current(self) -> bool:
        """Whether the motor's current is known."""
        return self.kind != "platform" and self.command != "torque"

    @property
    def longest_step(self) -> float:
        """Longest step of a time grid [s]: a sampling interval is divided until its parts are no longer than this, or by 2 % at most."""
        if self.kind != "joint":
            return LONGEST_STEP
        return OF_INDUCTIVE_JOINTS if self.inductive else OF_JOINTS

    @property
    def parts_of_step(self) -> int:
        """Parts into which each step of a time grid is divided further, since an effect asks for it [1]."""
        needed = min((BY_NAME[effect].longest_step for effect in self.effects), default=math.inf)
        return max(1, math.ceil(self.longest_step / needed - 1e-9))

    @property
    def halves(self) -> tuple["Structure", ...]:
        """Of a two-axis rig yaw with its wheel and pitch with its wheel, each as a `reaction` rig."""
        return _halves(self) if self.kind == "two_axis" else ()

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: those of the axis, of the wheel, then the effects' own as `effect:state`."""
        if self.halves:
            return tuple(_state(name, k) for k, half in enumerate(self.halves) for name in half.states)
        axis = ("psi", "w") if self.has_axis else ()
        wheel = ("theta", "Omega") if self.has_wheel else ()
        current = ("i",) if self.inductive else ()
        own = tuple(name for effect in self.effects for name in BY_NAME[effect].state_names())
        return axis + wheel + current + own + (self._servo_states if self.servo else ())

    @property
    def _servo_states(self) -> tuple[str, ...]:
        """Names of the states of a servo, as `plant.servo` moves them."""
        ports = [BY_NAME[effect] for effect in self.effects]
        late = LATE_TICKS + 1 if any(issubclass(port, CommandDelay) for port in ports) else 0
        read = LATE_TICKS + 2 if any(issubclass(port, EncoderDelay) for port in ports) else 0
        filters = [len(port.filter_states) for port in ports if issubclass(port, CommandFilter)]
        names = [
            "begun",
            "acting",
            *(f"given:{k}" for k in range(1 + late)),
            *(f"read:{k}" for k in range(read)),
            *(("seen", "slope") if f"{SERVO}.kd" in self.numbers else ()),
            *(("integral",) if f"{SERVO}.ki" in self.numbers else ()),
            *(f"filter:{k}" for k in range(sum(filters))),
        ]
        return tuple(f"{SERVO}:{name}" for name in names)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Outputs that are worked out, in the order of `OUTPUTS`; of a two-axis rig those of yaw, then of pitch."""
        return self.read or self._readable

    @property
    def _readable(self) -> tuple[str, ...]:
        """Outputs that this kind of rig has."""
        if self.halves:
            return tuple(half_column(name, k) for k, half in enumerate(self.halves) for name in half.outputs)
        axis = OUTPUTS[:2] if self.has_axis else ()
        return axis + (OUTPUTS[2:4] if self.has_wheel else ()) + (OUTPUTS[4:] if self.has_current else ())

    @property
    def turning(self) -> tuple[tuple[str, str, str, str], ...]:
        """Every turning body: its angle and rate among the states, and the outputs that read them."""
        if self.halves:
            every = [(k, body) for k, half in enumerate(self.halves) for body in half.turning]
            return tuple(
                (_state(a, k), _state(w, k), half_column(y, k), half_column(r, k)) for k, (a, w, y, r) in every
            )
        axis = (("psi", "w", "yaw_rad", "yaw_rad_s"),) if self.has_axis else ()
        return axis + ((("theta", "Omega", "wheel_rad", "wheel_rad_s"),) if self.has_wheel else ())

    @property
    def currents(self) -> tuple[tuple[str, str], ...]:
        """Every current among the states, and the output that reads it."""
        if self.halves:
            every = [(k, current) for k, half in enumerate(self.halves) for current in half.currents]
            return tuple((_state(i, k), half_column(y, k)) for k, (i, y) in every)
        return (("i", "current_A"),) if "i" in self.states else ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all numbers in the order of the parameter vector: base numbers, then effect parameters."""
        return self.numbers + tuple(
            f"{effect}.{name}" for effect in self.effects for name in parameters(BY_NAME[effect])
        )

    @property
    def from_library(self) -> bool:
        """Whether all effects are the library's own, so that its source of one version determines the program."""
        return all(BY_NAME[effect] in LIBRARY for effect in self.effects)

    @property
    def angles(self) -> set[str]:
        """The angles `psi`, `theta` on which something depends; of a two-axis rig the pitch in any case."""
        if self.halves:
            return {_state(name, k) for k, half in enumerate(self.halves) for name in half.angles} | {_state("psi", 1)}
        acting = [BY_NAME[effect] for effect in self.effects if BY_NAME[effect].at_angle]
        on_wheel = [not self.has_axis or issubclass(effect, WheelTorque | WheelDry) for effect in acting]
        gravity = {"psi"} if "axis.gravity.torque" in self.numbers else set()
        return {"theta" if wheel else "psi" for wheel in on_wheel} | gravity

    @property
    def longest_encoder_delay(self) -> float:
        """Largest age that a reading of the encoder may have [s]."""
        ports = (BY_NAME[effect] for effect in self.effects)
        return sum((port.longest for port in ports if issubclass(port, EncoderDelay)), 0.0)

    def vector(self, given: Mapping[str, float]) -> list[float]:
        """Parameter vector of numbers given by name.

        Args:
            given: Values by dotted name [SI].

        Returns:
            Values `(p,)` in the order of `names`, 0 for those not given [SI].
        """
        return [given.get(name, 0.0) for name in self.names]

    def as_reported(self, reading: Mapping[str, Scalar]) -> tuple[Scalar, ...]:
        """Readings as the rig's devices report them.

        Args:
            reading: Values of the outputs by name [SI].

        Returns:
            Values in the order of `outputs` [SI], of those in `unsigned` the size alone.
        """
        return tuple(abs(reading[name]) if name in self.unsigned else reading[name] for name in self.outputs)

    def reading(self, outputs: Collection[str]) -> "Structure":
        """The same structure with some outputs alone: what nobody reads is not worked out.

        Args:
            outputs: Names of outputs; others than those of this kind of rig do not count.

        Returns:
            A structure with these outputs, with all of its kind where none of them is named.
        """
        read = tuple(name for name in self._readable if name in outputs)
        return self._replace(read=() if read == self._readable else read)

    def with_every_output(self) -> "Structure":
        """The same structure with all outputs of this kind of rig.

        Returns:
            The structure.
        """
        return self._replace(read=())

    def with_effects(self, *effects: str) -> "Structure":
        """The same structure with further effects.

        Args:
            effects: Names of effects to add.

        Returns:
            A structure with all effects in the order of the library.
        """
        wanted = {*self.effects, *effects}
        return self._replace(effects=tuple(name for name in BY_NAME if name in wanted))


@cache
def _halves(structure: Structure) -> tuple[Structure, ...]:
    """Yaw and pitch of a two-axis rig, each as a `reaction` rig."""

    def of(half: int, names: tuple[str, ...]) -> tuple[str, ...]:
        found = (of_half(name) for name in names)
        return tuple(at[1] for at in found if at is not None and at[0] == half and at[1] in (*BY_NAME, *NUMBERS))

    numbers, effects = structure.numbers, structure.effects
    return tuple(
        Structure("reaction", of(k, numbers), "motor.inductance" in of(k, numbers), of(k, effects)) for k in range(2)
    )


def _state(name: str, half: int) -> str:
    """Name of one half's state: `psi_1`, and `yaw.presliding:z` for an effect's own."""
    return on_half(name, half) if ":" in name else f"{name}_{half + 1}"
