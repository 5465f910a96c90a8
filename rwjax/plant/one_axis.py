r"""The plant: base equations of a rig with effects on its ports.

`wheel`     $J\dot\Omega + b\,\Omega + M_w = K i$, $\;L\dot i + R i = V - K\Omega$
`platform`  $I\dot w + M_f + M_g = k V$
`reaction`  the wheel, and $I\dot w + M_f + M_g = -(K i - b\,\Omega - M_w)$
`two_axis`  in `rwjax.plant.two_axis`: two of these whose motions are coupled, each under the names of a `reaction` rig

$\Omega$ is the wheel's speed relative to the body (thesis eq. 3.1, 3.4, 4.2). $L = 0$ makes the current algebraic.
The state is a tuple of scalars: `psi, w` where there is an axis, then `theta, Omega` and, with inductance, `i`.
"""

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from rwjax.effects.effect import Effect, Motion
from rwjax.effects.library import BY_NAME, EFFECTS, ON_TWO_AXES
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import (
    AxisDry,
    AxisElastic,
    AxisTorque,
    Clock,
    CommandDelay,
    CommandFilter,
    CommandMap,
    Coupling,
    CurrentLimit,
    Encoder,
    EncoderDelay,
    MotorTorque,
    Supply,
    WheelDry,
    WheelTorque,
    Winding,
)
from rwjax.effects.rig_terms import of_rig_numbers
from rwjax.kinds import NUMBERS, half_column, of_half, on_half
from rwjax.types import Scalar

State = tuple[Scalar, ...]
Numbers = dict[str, Scalar]
"""Values by dotted name: `axis.inertia`, and `axis.stribeck.v_s` for parameters of effects."""

OUTPUTS = ("yaw_rad", "yaw_rad_s", "wheel_rad", "wheel_rad_s", "current_A")


class Structure(NamedTuple):
    """What decides which program is compiled: everything about a plant but its numbers."""

    kind: str
    numbers: tuple[str, ...]
    """Names of the base numbers."""
    inductive: bool
    effects: tuple[str, ...]

    @property
    def has_axis(self) -> bool:
        return self.kind != "wheel"

    @property
    def has_wheel(self) -> bool:
        return self.kind != "platform"

    @property
    def halves(self) -> tuple["Structure", ...]:
        """Of a two-axis rig yaw with its wheel and pitch with its wheel, each as a `reaction` rig."""
        return _halves(self) if self.kind == "two_axis" else ()

    @property
    def states(self) -> tuple[str, ...]:
        if self.halves:
            return tuple(_state(name, k) for k, half in enumerate(self.halves) for name in half.states)
        axis = ("psi", "w") if self.has_axis else ()
        wheel = (("theta", "Omega", "i") if self.inductive else ("theta", "Omega")) if self.has_wheel else ()
        own = tuple(f"{effect}:{state}" for effect in self.effects for state in BY_NAME[effect].states)
        return axis + wheel + own

    @property
    def outputs(self) -> tuple[str, ...]:
        """Outputs in the order of `OUTPUTS` that this kind of rig has; of a two-axis rig those of yaw, then of pitch."""
        if self.halves:
            return tuple(half_column(name, k) for k, half in enumerate(self.halves) for name in half.outputs)
        axis = OUTPUTS[:2] if self.has_axis else ()
        return axis + (OUTPUTS[2:] if self.has_wheel else ())

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
    def lasting(self) -> bool:
        """Whether the library's source, of one version, says all about it: programs of others are not kept on disk."""
        return all(BY_NAME[effect] in (*EFFECTS, *ON_TWO_AXES) for effect in self.effects)

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
    def latest(self) -> float:
        """Largest age that a reading of the encoder may have [s]."""
        ports = (BY_NAME[effect] for effect in self.effects)
        return sum((port.longest for port in ports if issubclass(port, EncoderDelay)), 0.0)

    def vector(self, given: Mapping[str, float]) -> list[float]:
        """The numbers given by name in the order of the parameter vector, 0 for the others."""
        return [given.get(name, 0.0) for name in self.names]

    def with_effects(self, *effects: str) -> "Structure":
        """The same rig with these effects besides, in the order of the library."""
        wanted = {*self.effects, *effects}
        return self._replace(effects=tuple(name for name in BY_NAME if name in wanted))


@cache
def _halves(structure: Structure) -> tuple[Structure, ...]:
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


class Body(NamedTuple):
    """A turning mass with dry friction on it: indices into the state, and how its friction enters the rates."""

    angle: int
    rate: int
    inertia: Scalar
    reaction: tuple[Scalar | float, ...]
    """Change of every state's rate per N m of dry friction."""


class Plant(eqx.Module):
    """Base equations and effects of one rig; all numbers are leaves."""

    structure: Structure = eqx.field(static=True)
    numbers: Numbers
    effects: tuple[Effect, ...]

    def on(self, port: type) -> list:
        """The effects on a port."""
        return [effect for effect in self.effects if isinstance(effect, port)]

    def motion(self, t: Scalar, x: State, u: Scalar) -> Motion:
        """State, command and time by name; the current follows from the voltage where L = 0."""
        s = dict(zip(self.structure.states, x, strict=True))
        zero = jnp.zeros_like(t)
        n = self.numbers
        m = Motion(
            t=t,
            V=u,
            load=zero,
            sensed=s["w"] if self.structure.has_axis else s["Omega"],
            own={name: value for name, value in s.items() if ":" in name},
            **{name: s.get(name, zero) for name in ("psi", "w", "theta", "Omega", "i")},
        )
        R = self._resistance(m)
        for effect in self.on(Supply):
            u = effect.voltage(u, self._current(s, u, R))
        if self.structure.has_wheel:
            s["i"] = self._current(s, u, R)
        load = n["drive.gain"] * u if self.structure.kind == "platform" else zero
        if self.structure.kind == "reaction":
            load = n["motor.friction"] * s["Omega"] - self._motor_torque(s["i"])
        return m._replace(V=u, load=load, i=s.get("i", zero))

    def _resistance(self, motion: Motion) -> Scalar:
        R = self.numbers.get("motor.resistance", jnp.ones(()))
        for effect in self.on(Winding):
            R = R * effect.resistance(motion)
        return R

    def _current(self, s: Mapping[str, Scalar], u: Scalar, R: Scalar) -> Scalar:
        """The current: a state, or what the voltage drives at once; of a platform's drive the current is not known, and its
        command stands for it."""
        if not self.structure.has_wheel:
            return u
        n = self.numbers
        i = s["i"] if self.structure.inductive else (u - n["motor.torque_constant"] * s["Omega"]) / R
        for effect in self.on(CurrentLimit):
            i = jnp.clip(i, -effect.limit(), effect.limit())
        return i

    def _motor_torque(self, i: Scalar) -> Scalar:
        torque = self.numbers["motor.torque_constant"] * i
        for effect in self.on(MotorTorque):
            torque = torque * effect.factor(i)
        return torque

    def within_limits(self, x: State) -> State:
        """The state with the current within what its driver allows."""
        for effect in self.on(CurrentLimit):
            if self.structure.inductive:
                k = self.structure.states.index("i")
                x = (*x[:k], jnp.clip(x[k], -effect.limit(), effect.limit()), *x[k + 1 :])
        return x

    def deflected(self, before: State, after: State, h: Scalar) -> State:
        """The state after a step with elastic friction as the step's way leaves it."""
        states = self.structure.states
        for effect in self.on(AxisElastic):
            k, w = states.index(f"{effect.name}:z"), states.index("w")
            z = effect.after(before[k], 0.5 * h * (before[w] + after[w]))
            after = (*after[:k], z, *after[k + 1 :])
        return after

    def act(self, command: Scalar) -> Scalar:
        """Voltage that acts for a command, before any delay."""
        for effect in self.on(CommandMap):
            command = effect.command(command)
        return command

    def follow(self, command: Float[Array, " steps"], h: Scalar) -> Float[Array, " steps"]:
        """What the drive makes of the voltage over steps of length `h` [s]."""
        for effect in self.on(CommandFilter):
            command = effect.follow(command, h)
        return command

    @property
    def filters(self) -> bool:
        """Whether the voltage follows the command over time."""
        return bool(self.on(CommandFilter))

    def pace(self) -> Scalar | float:
        """Seconds that pass in one second of the log."""
        pace = 1.0
        for effect in self.on(Clock):
            pace = pace * effect.pace()
        return pace

    def delay(self) -> Scalar | None:
        """Time by which commands act late [s], or None where no effect delays them."""
        delays = [effect.delay() for effect in self.on(CommandDelay)]
        return sum(delays[1:], delays[0]) if delays else None

    def age(self) -> Scalar | None:
        """Age of what the encoder reads [s], or None where no effect makes it late."""
        ages = [effect.delay() for effect in self.on(EncoderDelay)]
        return sum(ages[1:], ages[0]) if ages else None

    def field(self, t: Scalar, x: State, u: Scalar) -> State:
        """Rates of the state without dry friction; with `rwjax.simulation.reference` an ordinary diffrax vector field."""
        m, n = self.motion(t, x, u), self.numbers
        rates = self.inner(m)
        shaft = jnp.zeros_like(m.t)
        if self.structure.has_wheel:
            shaft = self.wheel_torque(m)
            rates["theta"] = m.Omega
            rates["Omega"] = shaft / n["wheel.inertia"]
        if self.structure.has_axis:
            drive = n["drive.gain"] * m.V if self.structure.kind == "platform" else -shaft
            for effect in self.on(Coupling):
                rates[f"{effect.name}:slip"] = (drive - effect.torque(m)) / (effect.share() * n["axis.inertia"])
                drive = effect.torque(m)
            rates["psi"], rates["w"] = m.w, self.axis_torque(m, drive) / self._axis_inertia()
            for effect in self.on(Coupling):
                rates[f"{effect.name}:twist"] = effect.mine(m)[1]
                rates[f"{effect.name}:slip"] -= rates["w"]
        return tuple(rates[name] for name in self.structure.states)

    def wheel_torque(self, m: Motion) -> Scalar:
        """Torque between body and wheel that turns the wheel forward, without dry friction [N m]."""
        shaft = self._motor_torque(m.i) - self.numbers["motor.friction"] * m.Omega
        return sum((effect.torque(m) for effect in self.on(WheelTorque)), start=shaft)

    def axis_torque(self, m: Motion, drive: Scalar) -> Scalar:
        """Torque that turns the axis forward, without dry friction that holds it, for what the drive transmits [N m]."""
        torque = sum((effect.torque(m) for effect in self.on(AxisTorque)), start=drive)
        for effect in self.on(AxisElastic):
            z, every = effect.mine(m)[0], [*self.on(AxisDry), effect]
            torque -= z * jnp.where(z > 0.0, friction_level(every, m, 1.0), friction_level(every, m, -1.0))
            torque -= effect.damping(m)
        return torque

    def inner(self, m: Motion) -> dict[str, Scalar]:
        """Rates of the states that turn nothing: the current and the effects' own, but for those of a coupling."""
        rates: dict[str, Scalar] = {}
        n = self.numbers
        if self.structure.inductive:
            back_emf = n["motor.torque_constant"] * m.Omega
            rates["i"] = (m.V - self._resistance(m) * m.i - back_emf) / n["motor.inductance"]
        for effect in self.effects:
            names = tuple(f"{effect.name}:{state}" for state in effect.states)
            if isinstance(effect, AxisElastic):
                rates |= {name: jnp.zeros_like(m.own[name]) for name in names}  # moved by `deflected`
            elif names and not isinstance(effect, Coupling):
                rates |= dict(zip(names, effect.drift(m), strict=True))
        return rates

    def _axis_inertia(self) -> Scalar:
        """Inertia that the axis's own friction acts on."""
        inertia = self.numbers["axis.inertia"]
        for effect in self.on(Coupling):
            inertia = inertia * (1.0 - effect.share())
        return inertia

    def bodies(self) -> list[tuple[Body, list]]:
        """Turning masses that carry dry friction, the driving one first, each with its friction effects."""
        states, n = self.structure.states, self.numbers
        found: list[tuple[Body, list]] = []
        coupled = {f"{effect.name}:slip": effect.share() * n["axis.inertia"] for effect in self.on(Coupling)}
        if self.structure.has_wheel and (dry := self.on(WheelDry)):
            J = n["wheel.inertia"]
            enters = {"Omega": -1.0 / J}
            if self.structure.has_axis:
                enters |= {name: 1.0 / inertia for name, inertia in coupled.items()} or {"w": 1.0 / n["axis.inertia"]}
            reaction = tuple(enters.get(name, 0.0) for name in states)
            found.append((Body(states.index("theta"), states.index("Omega"), J, reaction), dry))
        if self.structure.has_axis and (dry := self.on(AxisDry)) and not self.on(AxisElastic):
            I = self._axis_inertia()
            enters = {"w": -1.0 / I} | {name: 1.0 / I for name in coupled}
            reaction = tuple(enters.get(name, 0.0) for name in states)
            found.append((Body(states.index("psi"), states.index("w"), I, reaction), dry))
        return found

    def outputs(self, t: Scalar, x: State, u: Scalar, seen: State | None = None) -> tuple[Scalar, ...]:
        """Readings in SI, in the order of `Structure.outputs`; `seen`: the state that the encoder reads, where it is late."""
        m = self.motion(t, x, u)
        reading: dict[str, Scalar] = dict(zip(OUTPUTS, (m.psi, m.w, m.theta, m.Omega, m.i), strict=True))
        angle, rate = OUTPUTS[:2] if self.structure.has_axis else OUTPUTS[2:4]
        age = self.age()
        if seen is not None and age is not None:
            m = self.motion(t - age, seen, u)
            reading[angle], reading[rate] = (m.psi, m.w) if self.structure.has_axis else (m.theta, m.Omega)
        for effect in self.on(Encoder):
            reading[angle], reading[rate] = effect.read(reading[angle], reading[rate], m)
        return tuple(reading[name] for name in self.structure.outputs)


def friction_level(effects: list, motion: Motion, direction: float) -> Scalar:
    """Dry friction on one body [N m], never below 0: `friction_sum` where that is positive."""
    return jnp.maximum(friction_sum(effects, motion, direction), 0.0)


def friction_sum(effects: list, motion: Motion, direction: float) -> Scalar:
    """The sum of all levels [N m], each raised by the shares of the others."""
    own = [e.level(motion, direction) for e in effects]
    whole = sum(own, start=jnp.zeros_like(motion.t))
    raised = (
        e.share(motion) * (whole - level) for e, level in zip(effects, own, strict=True) if isinstance(e, AxisDry)
    )
    return sum(raised, start=whole)


def one_axis(structure: Structure, numbers: Numbers) -> Plant:
    """Plant of a rig with one axis or none, of a structure with these numbers (all names of `structure.names` must be there)."""
    parts = of_rig_numbers(numbers)
    for name in structure.effects:
        cls = BY_NAME[name]
        prefix = f"{name}."
        parts.append(cls(**{key[len(prefix) :]: value for key, value in numbers.items() if key.startswith(prefix)}))
    return Plant(structure=structure, numbers=numbers, effects=tuple(parts))
