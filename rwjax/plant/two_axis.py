r"""The plant with two axes: yaw carries pitch, each is turned by a reaction wheel of its own.

Yaw turns by $\psi$ about the vertical, and on it, about a horizontal axis through it, the pitch body by $\theta$; body axes x
(level at $\theta = 0$), y (the pitch axis), z (vertical at $\theta = 0$), all through the point where both axes meet. Wheel 2
turns about y, wheel 1 about an axis that leans by $s\theta$ from the vertical: $s = 0$ where the yaw body carries it, $s = 1$
where the pitch body does (`wheel_1.gyroscopic`). $\Omega_1, \Omega_2$ are relative to what carries the wheels. With
$c = \cos s\theta$ the kinetic energy is

$T = \tfrac12 A\dot\psi^2 + P\dot\psi\dot\theta + \tfrac12 B\dot\theta^2 + \tfrac12 J_1(\Omega_1 + c\,\dot\psi)^2 +
\tfrac12 J_2(\Omega_2 + \dot\theta)^2$,

$A = I + (I_{xx} - I_{zz})\sin^2\theta + I_{xz}\sin 2\theta, \qquad P = I_{xy}\sin\theta - I_{yz}\cos\theta$

since the pitch body turns at $(-\dot\psi\sin\theta, \dot\theta, \dot\psi\cos\theta)$. $I$ (`yaw.inertia`) is all that turns with yaw at
$\theta = 0$, $B$ (`pitch.inertia`) all that turns with pitch, both with the wheels' masses and transverse inertias but without
what they have about their own axes; $I_{xy} = \int xy\,dm$ and so on. The generalised momenta are

$p_\psi = A\dot\psi + P\dot\theta + c H_1, \quad p_\theta = B\dot\theta + P\dot\psi + H_2, \quad
H_1 = J_1(\Omega_1 + c\,\dot\psi), \quad H_2 = J_2(\Omega_2 + \dot\theta)$

and Lagrange's equations $\dot H_1 = \tau_1$, $\dot H_2 = \tau_2$, $\dot p_\psi = Q_\psi$, $\dot p_\theta = \partial T/\partial\theta + Q_\theta$ with the
motors' torques $\tau$ and all others $Q$:

$A\ddot\psi + P\ddot\theta = Q_\psi - c\tau_1 - c' H_1\dot\theta - A'\dot\psi\dot\theta - P'\dot\theta^2$

$P\ddot\psi + B\ddot\theta = Q_\theta - \tau_2 + c' H_1\dot\psi + \tfrac12 A'\dot\psi^2$

($'$: derivative by $\theta$). The terms in $c' = -s\sin s\theta$ are the gyroscopic torques; they do no work together. At $\theta = 0$,
$P = 0$ each axis is a `reaction` rig but for the acceleration of the body in $\dot H = J(\dot\Omega + \dot w)$, which that kind drops.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from rwjax.effects.effect import Effect, Motion
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import AxisDry, AxisElastic, Clock, EncoderDelay, WheelDry
from rwjax.effects.two_axis import Tilt, YawReading
from rwjax.kinds import half_column, on_half
from rwjax.plant.coupled_friction import friction_of_resting, mobility_with_held, solve_within
from rwjax.plant.dry_friction import friction_level, smooth_friction
from rwjax.plant.one_axis import OneAxis, one_axis
from rwjax.plant.plant import BodyTorque, Drive, FrictionRates, Plant, SmoothStep
from rwjax.plant.stick import stopped
from rwjax.plant.structure import Numbers, State, Structure
from rwjax.types import Scalar

Torques = tuple[Scalar, ...]
"""One number for each turning body, in the order of `RATES`."""
RATES = ("w_1", "w_2", "Omega_1", "Omega_2")
"""Rates of yaw, pitch, wheel 1 and wheel 2 among the states."""
ANGLES = ("psi_1", "psi_2", "theta_1", "theta_2")
"""Their angles."""


class Carried(NamedTuple):
    """The inertias at a pitch and their derivatives by it.

    Attributes:
        A: Inertia about the vertical [kg m2].
        dA: Its derivative by the pitch [kg m2/rad].
        P: Product of inertia that couples yaw and pitch [kg m2].
        dP: Its derivative by the pitch [kg m2/rad].
        c: Share of the yaw rate along the axis of wheel 1 [1].
        dc: Its derivative by the pitch [1/rad].
    """

    A: Scalar
    dA: Scalar
    P: Scalar
    dP: Scalar
    c: Scalar
    dc: Scalar


class TwoAxis(Plant):
    """Base equations and effects of a rig with two axes.

    Attributes:
        structure: What it is made of.
        numbers: Base numbers and parameters of effects by dotted name, in SI.
        halves: Yaw and pitch, each as a `reaction` rig, which give the torques.
        effects: The effects that belong to neither half alone.
    """

    numbers: Numbers
    halves: tuple[OneAxis, OneAxis]
    effects: tuple[Effect, ...]

    def split(self, x: State) -> tuple[State, State]:
        """The states of both halves.

        Args:
            x: State.

        Returns:
            State of yaw with its wheel, and of pitch with its wheel.
        """
        n = len(self.halves[0].structure.states)
        return x[:n], x[n:]

    def motions(self, t: Scalar, x: State, u: Float[Array, " 2"]) -> list[Motion]:
        """What the effects of each half may depend on.

        Args:
            t: Time since the run's first sample [s].
            x: State.
            u: Voltages `(2,)` [V].

        Returns:
            Motion of yaw, and of pitch.
        """
        return [
            half.motion(t, part, u[k]) for k, (half, part) in enumerate(zip(self.halves, self.split(x), strict=True))
        ]

    def carried(self, pitch: Scalar) -> Carried:
        """The inertias at a pitch.

        Args:
            pitch: Angle of the pitch body [rad].

        Returns:
            The inertias and their derivatives.
        """
        n, none = self.numbers, jnp.zeros(())
        D, xy, xz, yz = (
            n.get(f"gimbal.{name}", none) for name in ("difference", "product_xy", "product_xz", "product_yz")
        )
        s, c = jnp.sin(pitch), jnp.cos(pitch)
        share = next((effect.share() for effect in self.effects if isinstance(effect, Tilt)), none)
        return Carried(
            A=n["yaw.inertia"] + D * s * s + 2.0 * xz * s * c,
            dA=2.0 * D * s * c + 2.0 * xz * (c * c - s * s),
            P=xy * s - yz * c,
            dP=xy * c + yz * s,
            c=jnp.cos(share * pitch),
            dc=-share * jnp.sin(share * pitch),
        )

    def _accelerations(self, at: Carried, Q: Torques) -> Torques:
        """Accelerations by torques on yaw, pitch and the wheels where nothing turns."""
        n = self.numbers
        on_yaw, on_pitch = Q[0] - at.c * Q[2], Q[1] - Q[3]
        B, whole = n["pitch.inertia"], at.A * n["pitch.inertia"] - at.P * at.P
        yaw = (B * on_yaw - at.P * on_pitch) / whole
        pitch = (at.A * on_pitch - at.P * on_yaw) / whole
        return yaw, pitch, Q[2] / n["wheel_1.inertia"] - at.c * yaw, Q[3] / n["wheel_2.inertia"] - pitch

    def mobility(self, x: State) -> list[Torques]:
        """Inverse of the mass matrix: acceleration of every body by a torque of 1 N m on each.

        Args:
            x: State.

        Returns:
            One tuple for each torque, with one acceleration for each body [1/(kg m2)], both in the order of `RATES`.
        """
        at = self.carried(x[self.structure.states.index("psi_2")])
        one, zero = jnp.ones_like(at.c), jnp.zeros_like(at.c)
        return [self._accelerations(at, tuple(one if k == j else zero for k in range(4))) for j in range(4)]

    def field(self, t: Scalar, x: State, u: Float[Array, " 2"]) -> State:
        """Rates of the state without dry friction."""
        m, n = self.motions(t, x, u), self.numbers
        at = self.carried(m[1].psi)
        tau = [half.wheel_torque(mk) for half, mk in zip(self.halves, m, strict=True)]
        Q = [half.axis_torque(mk, jnp.zeros_like(t)) for half, mk in zip(self.halves, m, strict=True)]
        w, q = m[0].w, m[1].w
        H = n["wheel_1.inertia"] * (m[0].Omega + at.c * w)
        on_yaw = Q[0] - at.dc * H * q - at.dA * w * q - at.dP * q * q
        on_pitch = Q[1] + at.dc * H * w + 0.5 * at.dA * w * w
        a = self._accelerations(at, (on_yaw, on_pitch, *tau))
        found = []
        for k, (half, mk) in enumerate(zip(self.halves, m, strict=True)):
            spin = a[2 + k] if k else a[2] - at.dc * q * w
            rates = half.internal_rates(mk) | {"psi": mk.w, "w": a[k], "theta": mk.Omega, "Omega": spin}
            found += [rates[name] for name in half.structure.states]
        return tuple(found)

    def bodies(self) -> list[tuple[int, list]]:
        """Bodies with dry friction.

        Returns:
            The place of each in `RATES`, with its friction effects.
        """
        on_axis = [half.on(AxisDry) if not half.on(AxisElastic) else [] for half in self.halves]
        found = enumerate([*on_axis, *(half.on(WheelDry) for half in self.halves)])
        return [(body, effects) for body, effects in found if effects]

    def with_friction(
        self, t: Scalar, x: State, u: Float[Array, " 2"], start: State, begun: State | None = None
    ) -> FrictionRates:
        """Rates of the state with dry friction, and the torque on every body that carries any."""
        rates, states, dry = self.field(t, x, u), self.structure.states, self.bodies()
        if not dry:
            return FrictionRates(rates, [])
        at, bodies = [states.index(name) for name in RATES], [body for body, _ in dry]
        columns = self.mobility(x)
        G, levels = _among(columns, bodies), self._levels(t, x, u)
        ahead, back = (jnp.stack(each) for each in zip(*levels, strict=True))
        w, free = (jnp.stack([of[at[body]] for body in bodies]) for of in (start, rates))
        resting = (w == 0.0) & (ahead + back > 0.0)
        f = jnp.where(w > 0.0, ahead, jnp.where(w < 0.0, -back, 0.0))
        f, held = friction_of_resting(G, free, f, resting, ahead, back)
        a = jnp.where(held, 0.0, free - G @ f)  # exactly at rest, not to rounding
        alone = f + a / mobility_with_held(G, held)  # the torque on each body but for its own friction
        bound = jnp.clip(alone, -back, ahead)
        found = [
            rate - sum(columns[body][k] * f[j] for j, body in enumerate(bodies))
            for k, rate in enumerate(rates[place] for place in at)
        ]
        changed = dict(zip(at, found, strict=True)) | {at[body]: a[j] for j, body in enumerate(bodies)}
        excess = alone - bound
        return FrictionRates(
            tuple(changed.get(k, rate) for k, rate in enumerate(rates)),
            [BodyTorque(alone[j], excess[j]) for j in range(len(dry))],
        )

    def with_smooth_friction(self, t: Scalar, x: State, u: Float[Array, " 2"], width: Scalar) -> State:
        """Rates of the state with dry friction by a smooth sign."""
        rates, states, motions = list(self.field(t, x, u)), self.structure.states, self.motions(t, x, u)
        columns = self.mobility(x)
        for body, effects in self.bodies():
            friction = smooth_friction(effects, motions[body % 2], x[states.index(RATES[body])], width)
            for name, acceleration in zip(RATES, columns[body], strict=True):
                rates[states.index(name)] -= acceleration * friction
        halves = zip(self.halves, motions, self.split(x), self.split(tuple(rates)), strict=True)
        first, second = (half.limited(part, half.deflecting(m, of)) for half, m, part, of in halves)
        return first + second

    def _levels(self, t: Scalar, x: State, u: Float[Array, " 2"]) -> list[tuple[Scalar, Scalar]]:
        """Dry friction forward and backward of each body that has any [N m]."""
        motions = self.motions(t, x, u)
        return [
            (friction_level(effects, motions[body % 2], 1.0), friction_level(effects, motions[body % 2], -1.0))
            for body, effects in self.bodies()
        ]

    def settle(self, step: SmoothStep) -> State:
        """State at the end of a step: each body gets the speed that it ends with, by impulses that push the others, too."""
        x, x1, states = step.before, step.after, self.structure.states
        bodies = [body for body, _ in self.bodies()]
        if not bodies:
            return x1
        columns = self.mobility(x)
        G = _among(columns, bodies)
        resting = jnp.stack([x[states.index(RATES[body])] == 0.0 for body in bodies])
        within = jnp.stack([(a.excess == 0.0) & (b.excess == 0.0) for a, b in step.torques])
        mobility = mobility_with_held(G, resting & within)
        stops = []
        for k, body in enumerate(bodies):
            rate, angle = states.index(RATES[body]), states.index(ANGLES[body])
            rest = tuple(jnp.zeros_like(v) if j == rate else v for j, v in enumerate(x))
            levels = self._levels(step.t, rest, step.u)[k]
            rates, angles = (x[rate], x1[rate]), (x[angle], x1[angle])
            stops.append(stopped(rates, angles, step.rates[rate], step.h, 1.0 / mobility[k], levels, step.torques[k]))
        end, mended = jnp.stack([stop.rate for stop in stops]), jnp.stack([stop.mended for stop in stops])
        before = jnp.stack([x1[states.index(RATES[body])] for body in bodies])
        impulse = solve_within(G, end - before, mended)
        found = list(x1)
        for k, name in enumerate(RATES):
            found[states.index(name)] += sum(columns[body][k] * impulse[j] for j, body in enumerate(bodies))
        for stop, body in zip(stops, bodies, strict=True):
            rate, angle = states.index(RATES[body]), states.index(ANGLES[body])
            found[rate], found[angle] = jnp.where(stop.mended, stop.rate, found[rate]), stop.angle
        return tuple(found)

    def within_limits(self, x: State) -> State:
        """State with the currents within what their drivers allow."""
        first, second = (half.within_limits(part) for half, part in zip(self.halves, self.split(x), strict=True))
        return first + second

    def deflected(self, before: State, after: State, h: Scalar) -> State:
        """State after a step with the deflections of elastic friction that follow from the angles turned, and with the times at rest."""
        parts = zip(self.halves, self.split(before), self.split(after), strict=True)
        first, second = (half.deflected(old, new, h) for half, old, new in parts)
        return first + second

    def no_command(self) -> Float[Array, " 2"]:
        """Voltages of 0 V `(2,)`."""
        return jnp.zeros(2)

    def act(self, command: Float[Array, " 2"]) -> Float[Array, " 2"]:
        """Voltages that act for both commands, before any delay."""
        return jnp.stack([half.act(command[k]) for k, half in enumerate(self.halves)])

    def channels(self, command: Float[Array, "k 2"]) -> list[tuple[Drive, Float[Array, " k"]]]:
        """Each half's drive with its command."""
        return [(half, command[:, k]) for k, half in enumerate(self.halves)]

    def pace(self) -> Scalar | float:
        """Seconds that pass in one second of the log [1]."""
        return next((effect.pace() for effect in self.effects if isinstance(effect, Clock)), 1.0)

    def age(self) -> Scalar | None:
        """Age of what the encoders of both axes read [s], or None where no effect makes it late."""
        return next((effect.delay() for effect in self.effects if isinstance(effect, EncoderDelay)), None)

    def outputs(self, t: Scalar, x: State, u: Float[Array, " 2"], seen: State | None = None) -> tuple[Scalar, ...]:
        """Readings in SI, in the order of `structure.outputs`."""
        age = self.age()
        late, then = (x, t) if seen is None or age is None else (seen, t - age)
        reading: dict[str, Scalar] = {}
        for k, (half, part, old) in enumerate(zip(self.halves, self.split(x), self.split(late), strict=True)):
            now, axis = half.outputs(t, part, u[k]), half.outputs(then, old, u[k])[:2]
            names = (half_column(name, k) for name in half.structure.outputs)
            reading |= dict(zip(names, (*axis, *now[2:]), strict=True))
        states = self.structure.states
        for effect in (e for e in self.effects if isinstance(e, YawReading)):
            for name, pitch in (("yaw_rad", "psi_2"), ("yaw_rad_s", "w_2")):
                reading[name] = effect.read(reading[name], late[states.index(pitch)])
        return self.structure.as_reported(reading)


def _among(columns: list[Torques], bodies: list[int]) -> Float[Array, "b b"]:
    """The inverse of the mass matrix for some bodies `(b, b)` [1/(kg m2)]."""
    return jnp.stack([jnp.stack([columns[j][i] for j in bodies]) for i in bodies])


def two_axis(structure: Structure, numbers: Numbers) -> TwoAxis:
    """Plant of a rig with two axes.

    Args:
        structure: What it is made of.
        numbers: Value of every name of `structure.names` [SI].

    Returns:
        The plant.
    """
    halves = []
    for k, half in enumerate(structure.halves):
        halves.append(one_axis(half, {name: numbers[on_half(name, k)] for name in half.names}))
    of_halves = {on_half(effect, k) for k, half in enumerate(structure.halves) for effect in half.effects}
    both = []
    for name in (effect for effect in structure.effects if effect not in of_halves):
        given = {key.rpartition(".")[2]: v for key, v in numbers.items() if key.rpartition(".")[0] == name}
        both.append(BY_NAME[name](**given))
    return TwoAxis(structure=structure, numbers=numbers, halves=(halves[0], halves[1]), effects=tuple(both))
