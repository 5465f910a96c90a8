r"""The plant with one axis, or with a wheel alone: base equations of a rig with effects on its ports.

`wheel`     $J\dot\Omega + b\,\Omega + M_w = K i$, $\;L\dot i + R i = V - K\Omega$
`platform`  $I\dot w + M_f + M_g = k V$
`reaction`  the wheel, and $I\dot w + M_f + M_g = -(K i - b\,\Omega - M_w)$
`joint`     $(I + N^2 J)\dot w + M_f + M_g = N K i$, $\;L\dot i + R i = V - K N w$
`two_axis`  in `rwjax.plant.two_axis`: two of these whose motions are coupled, each under the names of a `reaction` rig

$\Omega$ is the wheel's speed relative to the body (thesis eq. 3.1, 3.4, 4.2), of a joint the motor's. $L = 0$ makes the current
algebraic. A drive that is given a current or a joint's torque makes it at once. Without torque the circuit is open: no current flows.
The state is a tuple of scalars: `psi, w` where there is an axis, then `theta, Omega`, with inductance `i`, then those of effects
and of the servo.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from rwjax.effects.effect import Effect, Motion
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import (
    AxisAgeing,
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
    Inertia,
    Kept,
    MotorTorque,
    Reading,
    Supply,
    WheelDry,
    WheelTorque,
    Winding,
)
from rwjax.effects.rig_terms import of_rig_numbers
from rwjax.plant.dry_friction import friction_level, smooth_friction
from rwjax.plant.plant import BodyTorque, Drive, Followed, FrictionRates, Plant, SmoothStep
from rwjax.plant.stick import stopped
from rwjax.plant.structure import OUTPUTS, Numbers, State, Structure
from rwjax.types import Scalar


class Body(NamedTuple):
    """A turning mass with dry friction on it.

    Attributes:
        angle: Index of its angle in the state.
        rate: Index of its rate in the state.
        inertia: What its own dry friction acts on [kg m2].
        reaction: Change of every state's rate per 1 N m of its dry friction.
    """

    angle: int
    rate: int
    inertia: Scalar
    reaction: tuple[Scalar | float, ...]


def _pushed(values: State, body: Body, push: Scalar) -> State:
    """Rates, or states, changed by a body's reaction to a torque [N m], or to an impulse [N m s]."""
    return tuple(
        v + c * push if not isinstance(c, float) or c else v for v, c in zip(values, body.reaction, strict=True)
    )


def _replaced(names: tuple[str, ...], values: State, changed: Mapping[str, Scalar]) -> State:
    """States, or their rates, with some changed by name."""
    return tuple(changed.get(name, value) for name, value in zip(names, values, strict=True))


class OneAxis(Plant):
    """Base equations and effects of a rig of the kinds `kinds.ONE_AXIS`.

    Attributes:
        structure: What it is made of.
        numbers: Base numbers and parameters of effects by dotted name, in SI.
        effects: Parts that act on its ports: those of the rig's own friction and load, then the structure's effects.
        torque_on: Share of the time in which current can flow `()` [1]; None where it always can.
    """

    numbers: Numbers
    effects: tuple[Effect, ...]
    torque_on: Float[Array, ""] | None = None

    def on(self, port: type) -> list:
        """The effects on a port.

        Args:
            port: Class of the port, as `rwjax.effects.ports.AxisDry`.

        Returns:
            The effects on it, in their order.
        """
        return [effect for effect in self.effects if isinstance(effect, port)]

    def motion(self, t: Scalar, x: State, u: Scalar) -> Motion:
        """State, command and time by name; the current follows from the voltage where L = 0.

        Args:
            t: Time since the run's first sample [s].
            x: State.
            u: Voltage before what load takes away [V].

        Returns:
            What the effects may depend on.
        """
        s = dict(zip(self.structure.states, x, strict=True))
        zero = jnp.zeros_like(t)
        n = self.numbers
        if self.structure.kind == "joint":
            s["Omega"] = self._ratio() * self._drive_side(s)[1]
        if not self.structure.has_current:
            u = self._switched(u)
        m = Motion(
            t=t,
            V=u,
            drawn=zero,
            load=zero,
            sensed=self._encoder_side(s)[1] if self.structure.has_axis else s["Omega"],
            own={name: value for name, value in s.items() if ":" in name},
            **{name: s.get(name, zero) for name in ("psi", "w", "theta", "Omega", "i")},
        )
        R = self._resistance(m)
        for effect in self.on(Supply):
            i = self._current(s, u, R) if self.structure.has_current else 1.0
            m = m._replace(drawn=jnp.abs(u * i))
            u = effect.voltage(u, m)
        if self.structure.kind != "platform":
            s["i"] = self._current(s, u, R)
        load = n["drive.gain"] * u if self.structure.kind == "platform" else zero
        if self.structure.kind == "reaction":
            load = n["motor.friction"] * s["Omega"] - self._motor_torque(s["i"])
        if self.structure.kind == "joint":
            load = self._geared_torque(u, s["i"])
        return m._replace(V=u, load=load, i=s.get("i", zero))

    def _switched(self, u: Scalar) -> Scalar:
        """What is left of a voltage or a current where torque may be off."""
        return u if self.torque_on is None else self.torque_on * u

    def _ratio(self) -> Scalar:
        """Ratio of a joint's gear [1]."""
        return self.numbers.get("gear.ratio", jnp.ones(()))

    def _drive_side(self, s: Mapping[str, Scalar]) -> tuple[Scalar, Scalar]:
        """Angle [rad] and rate [rad/s] of the axis on the drive's side of a coupling, by the states' names."""
        angle, rate = s["psi"], s["w"]
        for effect in self.on(Coupling):
            angle, rate = angle + s[f"{effect.name}:twist"], rate + s[f"{effect.name}:slip"]
        return angle, rate

    def _encoder_side(self, s: Mapping[str, Scalar]) -> tuple[Scalar, Scalar]:
        """Angle [rad] and rate [rad/s] of the axis where its encoder sits, by the states' names."""
        return self._drive_side(s) if self.structure.encoder_side == "motor" else (s["psi"], s["w"])

    def _geared_torque(self, u: Scalar, i: Scalar) -> Scalar:
        """Torque of a joint's motor behind its gear [N m]: the command itself where that is a torque."""
        return u if self.structure.command == "torque" else self._ratio() * self._motor_torque(i)

    def _resistance(self, motion: Motion) -> Scalar:
        """Resistance of the winding [ohm]."""
        R = self.numbers.get("motor.resistance", jnp.ones(()))
        for effect in self.on(Winding):
            R = R * effect.resistance(motion)
        return R

    def _current(self, s: Mapping[str, Scalar], u: Scalar, R: Scalar) -> Scalar:
        """Current [A]: a state, what the voltage drives at once, or the command, which stands for it where it is not known."""
        if not self.structure.has_current:
            return u
        n, i = self.numbers, u
        if self.structure.inductive:
            i = s["i"]
        elif self.structure.command != "current":
            i = (u - n["motor.torque_constant"] * s["Omega"]) / R
        for effect in self.on(CurrentLimit):
            i = jnp.clip(i, -effect.limit(), effect.limit())
        return self._switched(i)

    def _motor_torque(self, i: Scalar) -> Scalar:
        """Torque of the motor [N m] for a current [A]."""
        torque = self.numbers["motor.torque_constant"] * i
        for effect in self.on(MotorTorque):
            torque = torque * effect.factor(i)
        return torque

    def within_limits(self, x: State) -> State:
        """State with the current within what its driver allows."""
        for effect in self.on(CurrentLimit):
            if self.structure.inductive:
                k = self.structure.states.index("i")
                x = (*x[:k], jnp.clip(x[k], -effect.limit(), effect.limit()), *x[k + 1 :])
        return x

    def deflected(self, before: State, after: State, h: Scalar) -> State:
        """State after a step with the deflection of elastic friction that follows from the angle turned, and with the time at rest."""
        states = self.structure.states
        for effect in self.on(AxisAgeing):
            k, w = states.index(f"{effect.name}:rest"), states.index("w")
            after = (*after[:k], jnp.where(before[w] == 0.0, before[k] + h, 0.0), *after[k + 1 :])
        for effect in self.on(AxisElastic):
            own, w = effect.state_names(), states.index("w")
            bent = effect.after(tuple(before[states.index(name)] for name in own), 0.5 * h * (before[w] + after[w]))
            after = _replaced(states, after, dict(zip(own, bent, strict=True)))
        return after

    def no_command(self) -> Scalar:
        """Voltage of 0 V."""
        return jnp.zeros(())

    def act(self, command: Scalar) -> Scalar:
        """What acts for a command, before any delay: voltage [V], or current [A] or torque [N m] where the drive makes these."""
        if "drive.supply" in self.numbers:
            command = self.numbers["drive.supply"] * command
        for effect in self.on(CommandMap):
            command = effect.command(command)
        return command

    def follow(self, command: Float[Array, " steps"], h: Scalar) -> Followed:
        """What lags and rate limits of the drive make of the voltage.

        Args:
            command: Voltage over every step `(s,)` [V].
            h: Length of a step [s].

        Returns:
            The voltage that follows it.
        """
        mean, row = command, list[tuple[CommandFilter, Kept]]()
        for effect in self.on(CommandFilter):
            mean, kept = effect.follow(mean, h)
            row.append((effect, kept))

        def at(step: Int[Array, ""], before: Scalar, now: Scalar, time: Scalar, span: Scalar) -> Scalar:
            for effect, kept in row:
                then, before = effect.over(time)(tuple(x[step] for x in kept), before)
                _, now = effect.over(span)(then, now)
            return now

        return Followed(mean, at)

    @property
    def filters(self) -> bool:
        """Whether the voltage follows the command over time."""
        return bool(self.on(CommandFilter))

    def channels(self, command: Float[Array, " k"]) -> list[tuple[Drive, Float[Array, " k"]]]:
        """The drive with its command."""
        return [(self, command)]

    def pace(self) -> Scalar | float:
        """Seconds that pass in one second of the log [1]."""
        pace = 1.0
        for effect in self.on(Clock):
            pace = pace * effect.pace()
        return pace

    def delay(self) -> Scalar | None:
        """Time by which commands act late.

        Returns:
            The time [s], or None where no effect delays them.
        """
        delays = [effect.delay() for effect in self.on(CommandDelay)]
        return sum(delays[1:], delays[0]) if delays else None

    def age(self) -> Scalar | None:
        """Age of what the encoder reads [s], or None where no effect makes it late."""
        ages = [effect.delay() for effect in self.on(EncoderDelay)]
        return sum(ages[1:], ages[0]) if ages else None

    def field(self, t: Scalar, x: State, u: Scalar) -> State:
        """Rates of the state without dry friction."""
        m, n = self.motion(t, x, u), self.numbers
        rates = self.internal_rates(m)
        shaft = jnp.zeros_like(m.t)
        if self.structure.has_wheel:
            shaft = self.wheel_torque(m)
            rates["theta"] = m.Omega
            rates["Omega"] = shaft / self._wheel_inertia(m)
        if self.structure.has_axis:
            drive = n["drive.gain"] * m.V if self.structure.kind == "platform" else -shaft
            if self.structure.kind == "joint":
                drive = m.load
            for effect in self.on(Coupling):
                rates[f"{effect.name}:slip"] = (drive - effect.torque(m)) / (effect.share() * self.whole_inertia())
                drive = effect.torque(m)
            rates["psi"], rates["w"] = m.w, self.axis_torque(m, drive) / self._axis_inertia(m)
            for effect in self.on(Coupling):
                rates[f"{effect.name}:twist"] = effect.mine(m)[1]
                rates[f"{effect.name}:slip"] -= rates["w"]
        if self.structure.servo is not None:  # what a servo keeps in mind changes at its ticks, not by a rate
            rates |= {name: jnp.zeros_like(m.t) for name in self.structure.states if name not in rates}
        return tuple(rates[name] for name in self.structure.states)

    def wheel_torque(self, m: Motion) -> Scalar:
        """Torque between body and wheel that turns the wheel forward, without dry friction.

        Args:
            m: What the effects may depend on.

        Returns:
            Torque [N m].
        """
        shaft = self._motor_torque(m.i) - self.numbers["motor.friction"] * m.Omega
        return sum((effect.torque(m) for effect in self.on(WheelTorque)), start=shaft)

    def axis_torque(self, m: Motion, drive: Scalar) -> Scalar:
        """Torque that turns the axis forward, without dry friction that could hold it.

        Args:
            m: What the effects may depend on.
            drive: Torque that the drive transmits to the axis [N m].

        Returns:
            Torque [N m].
        """
        torque = sum((effect.torque(m) for effect in self.on(AxisTorque)), start=drive)
        for effect in self.on(AxisElastic):
            share, every = effect.built_up(effect.mine(m)), [*self.on(AxisDry), effect]
            torque -= share * jnp.where(share > 0.0, friction_level(every, m, 1.0), friction_level(every, m, -1.0))
            torque -= effect.damping(m)
        return torque

    def internal_rates(self, m: Motion) -> dict[str, Scalar]:
        """Rates of the states that are no motion of a body: the current and the effects' own states.

        Args:
            m: What the effects may depend on.

        Returns:
            Rates by name of state, in the state's unit per second; the states of a coupling are left out.
        """
        rates: dict[str, Scalar] = {}
        n = self.numbers
        if self.structure.inductive:
            back_emf = n["motor.torque_constant"] * m.Omega
            rates["i"] = self._switched((m.V - self._resistance(m) * m.i - back_emf) / n["motor.inductance"])
        for effect in self.effects:
            names = effect.state_names()
            if isinstance(effect, AxisElastic | AxisAgeing):
                rates |= {name: jnp.zeros_like(m.own[name]) for name in names}  # moved by `deflected`
            elif names and not isinstance(effect, Coupling):
                rates |= dict(zip(names, effect.drift(m), strict=True))
        return rates

    def whole_inertia(self) -> Scalar:
        """Inertia that the drive turns: that of the axis, of a joint with the motor's behind its gear.

        Returns:
            The inertia [kg m2].
        """
        inertia = self.numbers["axis.inertia"]
        if "motor.inertia" in self.numbers:
            inertia = inertia + self._ratio() ** 2 * self.numbers["motor.inertia"]
        return inertia

    def _axis_inertia(self, m: Motion | None) -> Scalar:
        """Inertia that the axis's own friction acts on, at standstill without a motion."""
        inertia = self.whole_inertia()
        for effect in self.on(Coupling):
            inertia = inertia * (1.0 - effect.share())
        return inertia if m is None else self._grown(inertia, m.w)

    def _wheel_inertia(self, m: Motion | None) -> Scalar:
        """Inertia of the wheel, at standstill without a motion."""
        inertia = self.numbers["wheel.inertia"]
        return inertia if m is None or self.structure.has_axis else self._grown(inertia, m.Omega)

    def _grown(self, inertia: Scalar, w: Scalar) -> Scalar:
        """Inertia at a rate [rad/s] of one that is so large at standstill [kg m2]."""
        return math.prod((effect.factor(w) for effect in self.on(Inertia)), start=inertia)

    def bodies(self, m: Motion | None = None) -> list[tuple[Body, list]]:
        """Turning masses that carry dry friction, the driving one first.

        Args:
            m: What their inertias may depend on; None for those at standstill.

        Returns:
            Each body with its friction effects.
        """
        states = self.structure.states
        found: list[tuple[Body, list]] = []
        coupled = {f"{effect.name}:slip": effect.share() * self.whole_inertia() for effect in self.on(Coupling)}
        if self.structure.has_wheel and (dry := self.on(WheelDry)):
            J = self._wheel_inertia(m)
            enters = {"Omega": -1.0 / J}
            if self.structure.has_axis:
                enters |= {name: 1.0 / inertia for name, inertia in coupled.items()} or {
                    "w": 1.0 / self._axis_inertia(m)
                }
            reaction = tuple(enters.get(name, 0.0) for name in states)
            found.append((Body(states.index("theta"), states.index("Omega"), J, reaction), dry))
        if self.structure.has_axis and (dry := self.on(AxisDry)) and not self.on(AxisElastic):
            I = self._axis_inertia(m)
            enters = {"w": -1.0 / I} | {name: 1.0 / I for name in coupled}
            reaction = tuple(enters.get(name, 0.0) for name in states)
            found.append((Body(states.index("psi"), states.index("w"), I, reaction), dry))
        return found

    def with_friction(self, t: Scalar, x: State, u: Scalar, start: State, begun: State | None = None) -> FrictionRates:
        """Rates of the state with dry friction, and the torque on every body that carries any."""
        rates = self.field(t, x, u) if begun is None else self._through_contacts(t, begun, x, u)
        motion = self.motion(t, x, u)
        torques = []
        for body, effects in self.bodies(motion):
            free = rates[body.rate] * body.inertia
            forward, backward = friction_level(effects, motion, 1.0), friction_level(effects, motion, -1.0)
            w = start[body.rate]
            holding = jnp.clip(free, -backward, forward)
            friction = jnp.where(w > 0.0, forward, jnp.where(w < 0.0, -backward, holding))
            rates = _pushed(rates, body, friction)
            torques.append(BodyTorque(free, free - holding))
        return FrictionRates(rates, torques)

    def _through_contacts(self, t: Scalar, begun: State, x: State, u: Scalar) -> State:
        """Rates without dry friction at the end of a step, with what makes the mean of both ends that over the step."""
        names = self.structure.states
        rates = dict(zip(names, self.field(t, x, u), strict=True))
        for effect in self.on(Coupling):
            before, after = self.motion(t, begun, u), self.motion(t, x, u)
            missing = 2.0 * effect.mean_torque(before, after) - effect.torque(before) - effect.torque(after)
            w = missing / self._axis_inertia(after)
            rates["w"] += w
            rates[f"{effect.name}:slip"] -= missing / (effect.share() * self.whole_inertia()) + w
        return tuple(rates[name] for name in names)

    def with_smooth_friction(self, t: Scalar, x: State, u: Scalar, width: Scalar) -> State:
        """Rates of the state with dry friction by a smooth sign."""
        rates, motion = self.field(t, x, u), self.motion(t, x, u)
        for body, effects in self.bodies(motion):
            friction = smooth_friction(effects, motion, x[body.rate], width)
            rates = _pushed(rates, body, friction)
        return self.limited(x, self.deflecting(motion, rates))

    def deflecting(self, motion: Motion, rates: State) -> State:
        """Rates of the state with those of the deflections of elastic friction.

        Args:
            motion: What the effects may depend on.
            rates: Rates in which the deflections are taken to stay.

        Returns:
            The rates.
        """
        for effect in self.on(AxisElastic):
            moving = zip(effect.state_names(), effect.rates(effect.mine(motion), motion.w), strict=True)
            rates = _replaced(self.structure.states, rates, dict(moving))
        return rates

    def limited(self, x: State, rates: State) -> State:
        """Rates of the state in which no current leaves what its driver allows.

        Args:
            x: State.
            rates: Rates without the driver's limit.

        Returns:
            The rates.
        """
        for effect in self.on(CurrentLimit):
            if self.structure.inductive:
                k = self.structure.states.index("i")
                leaves = (jnp.abs(x[k]) >= effect.limit()) & (x[k] * rates[k] > 0.0)
                rates = (*rates[:k], jnp.where(leaves, 0.0, rates[k]), *rates[k + 1 :])
        return rates

    def settle(self, step: SmoothStep) -> State:
        """State at the end of a step, each body stopped, turned or held by itself, the driving one first."""
        for k, (body, effects) in enumerate(self.bodies(self.motion(step.t, step.before, step.u))):
            if body.rate != step.sliding:
                step = step._replace(after=self._settled(step, body, effects, step.torques[k]))
        return step.after

    def _settled(self, step: SmoothStep, body: Body, effects: list, torques: tuple[BodyTorque, BodyTorque]) -> State:
        """State at a step's end with one body stopped, turned or held where its dry friction does so."""
        x, x1 = step.before, step.after
        rest = self.motion(step.t, tuple(jnp.zeros_like(v) if k == body.rate else v for k, v in enumerate(x)), step.u)
        levels = friction_level(effects, rest, 1.0), friction_level(effects, rest, -1.0)
        rates, angles = (x[body.rate], x1[body.rate]), (x[body.angle], x1[body.angle])
        end, angle, _ = stopped(rates, angles, step.rates[body.rate], step.h, body.inertia, levels, torques)
        impulse = (end - x1[body.rate]) / body.reaction[body.rate]
        mended = [*_pushed(x1, body, impulse)]
        mended[body.rate], mended[body.angle] = end, angle
        return tuple(mended)

    def outputs(self, t: Scalar, x: State, u: Scalar, seen: State | None = None) -> tuple[Scalar, ...]:
        """Readings in SI, in the order of `structure.outputs`."""
        m = self.motion(t, x, u)
        reading: dict[str, Scalar] = dict(zip(OUTPUTS, (m.psi, m.w, m.theta, m.Omega, m.i), strict=True))
        angle, rate = OUTPUTS[:2] if self.structure.has_axis else OUTPUTS[2:4]
        age = self.age()
        if seen is not None and age is not None:
            m, x = self.motion(t - age, seen, u), seen
        reading[angle], reading[rate] = self._at_encoder(m, x)
        for effect in self.on(Encoder):
            reading[angle], reading[rate] = effect.read(reading[angle], reading[rate], m)
        for effect in self.on(Reading):
            reading = {name: effect.read(name, value) for name, value in reading.items()}
        return self.structure.as_reported(reading)

    def _at_encoder(self, m: Motion, x: State) -> tuple[Scalar, Scalar]:
        """Angle [rad] and rate [rad/s] where the encoder sits that `Encoder` and `EncoderDelay` are about."""
        if not self.structure.has_axis:
            return m.theta, m.Omega
        return self._encoder_side(dict(zip(self.structure.states, x, strict=True)))

    def servo_reads(self, t: Scalar, x: State) -> tuple[Scalar, Scalar]:
        """Angle and rate that a servo reads, its sensor's errors included but for its age.

        Args:
            t: Time since the run's first sample [s].
            x: State.

        Returns:
            The angle [rad], not in counts, and the rate [rad/s].
        """
        m = self.motion(t, x, self.no_command())
        angle, rate = self._at_encoder(m, x)
        for effect in self.on(Encoder):
            angle, rate = effect.read(angle, rate, m)
        return angle, rate

    def without_servo(self) -> "OneAxis":
        """This plant without the states of its servo, which change from tick to tick.

        Returns:
            The plant.
        """
        return replace(self, structure=self.structure._replace(servo=None))

    def powered(self, on: Float[Array, ""]) -> "OneAxis":
        """This plant where torque may be off.

        Args:
            on: Share of the time in which current can flow `()` [1].

        Returns:
            The plant.
        """
        return replace(self, torque_on=on)

    def opened(self, x: State) -> State:
        """State with no current where torque is off.

        Args:
            x: State.

        Returns:
            The state.
        """
        if not self.structure.inductive:
            return x
        k = self.structure.states.index("i")
        return (*x[:k], jnp.where(self.torque_on == 0.0, 0.0, x[k]), *x[k + 1 :])


def one_axis(structure: Structure, numbers: Numbers) -> OneAxis:
    """Plant of a rig with one axis or none.

    Args:
        structure: What it is made of.
        numbers: Value of every name of `structure.names` [SI].

    Returns:
        The plant.
    """
    parts = of_rig_numbers(numbers)
    for name in structure.effects:
        cls = BY_NAME[name]
        prefix = f"{name}."
        parts.append(cls(**{key[len(prefix) :]: value for key, value in numbers.items() if key.startswith(prefix)}))
    return OneAxis(structure=structure, numbers=numbers, effects=tuple(parts))
