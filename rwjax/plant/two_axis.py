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

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from rwjax.effects.effect import Effect
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import AxisDry, AxisElastic, Clock, EncoderDelay, WheelDry
from rwjax.effects.two_axis import Tilt, YawReading
from rwjax.kinds import half_column, on_half
from rwjax.plant.one_axis import Numbers, Plant, State, Structure, one_axis
from rwjax.types import Scalar

Torques = tuple[Scalar, ...]
"""One number for each turning body, in the order of `RATES`."""
RATES = ("w_1", "w_2", "Omega_1", "Omega_2")
ANGLES = ("psi_1", "psi_2", "theta_1", "theta_2")


class Carried(eqx.Module):
    """The inertias at a pitch and their derivatives by it: `A`, `P` and `c` of the kinetic energy."""

    A: Scalar
    dA: Scalar
    P: Scalar
    dP: Scalar
    c: Scalar
    dc: Scalar


class TwoAxis(eqx.Module):
    """Base equations and effects of a rig with two axes; `halves`: yaw and pitch, each as a `reaction` rig, which give the
    torques; `effects`: those that belong to neither half alone."""

    structure: Structure = eqx.field(static=True)
    numbers: Numbers
    halves: tuple[Plant, Plant]
    effects: tuple[Effect, ...]

    def split(self, x: State) -> tuple[State, State]:
        """The states of both halves."""
        n = len(self.halves[0].structure.states)
        return x[:n], x[n:]

    def motions(self, t: Scalar, x: State, u: Float[Array, " 2"]) -> list:
        """What the effects of each half may depend on."""
        return [
            half.motion(t, part, u[k]) for k, (half, part) in enumerate(zip(self.halves, self.split(x), strict=True))
        ]

    def carried(self, pitch: Scalar) -> Carried:
        """The inertias at a pitch [rad]."""
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
        """Acceleration of every body by a torque of 1 N m on each, one tuple a torque: the inverse of the mass matrix."""
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
            rates = half.inner(mk) | {"psi": mk.w, "w": a[k], "theta": mk.Omega, "Omega": spin}
            found += [rates[name] for name in half.structure.states]
        return tuple(found)

    def dry(self) -> list[tuple[int, list]]:
        """Bodies with dry friction, by their place in `RATES`, each with its friction effects."""
        on_axis = [half.on(AxisDry) if not half.on(AxisElastic) else [] for half in self.halves]
        found = enumerate([*on_axis, *(half.on(WheelDry) for half in self.halves)])
        return [(body, effects) for body, effects in found if effects]

    def within_limits(self, x: State) -> State:
        """The state with the currents within what their drivers allow."""
        first, second = (half.within_limits(part) for half, part in zip(self.halves, self.split(x), strict=True))
        return first + second

    def deflected(self, before: State, after: State, h: Scalar) -> State:
        """The state after a step with elastic friction as the step's way leaves it."""
        parts = zip(self.halves, self.split(before), self.split(after), strict=True)
        first, second = (half.deflected(old, new, h) for half, old, new in parts)
        return first + second

    def act(self, command: Float[Array, " 2"]) -> Float[Array, " 2"]:
        """Voltages that act for both commands, before any delay."""
        return jnp.stack([half.act(command[k]) for k, half in enumerate(self.halves)])

    def pace(self) -> Scalar | float:
        """Seconds that pass in one second of the log."""
        return next((effect.pace() for effect in self.effects if isinstance(effect, Clock)), 1.0)

    def age(self) -> Scalar | None:
        """Age of what the encoders of both axes read [s], or None where no effect makes it late."""
        return next((effect.delay() for effect in self.effects if isinstance(effect, EncoderDelay)), None)

    def outputs(self, t: Scalar, x: State, u: Float[Array, " 2"], seen: State | None = None) -> tuple[Scalar, ...]:
        """Readings in SI, in the order of `Structure.outputs`; `seen`: the state that the axes' encoders read, where late."""
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
        return tuple(reading[name] for name in self.structure.outputs)


def two_axis(structure: Structure, numbers: Numbers) -> TwoAxis:
    """Plant of a rig with two axes, of a structure with these numbers (all names of `structure.names` must be there)."""
    halves = []
    for k, half in enumerate(structure.halves):
        halves.append(one_axis(half, {name: numbers[on_half(name, k)] for name in half.names}))
    of_halves = {on_half(effect, k) for k, half in enumerate(structure.halves) for effect in half.effects}
    both = []
    for name in (effect for effect in structure.effects if effect not in of_halves):
        given = {key.rpartition(".")[2]: v for key, v in numbers.items() if key.rpartition(".")[0] == name}
        both.append(BY_NAME[name](**given))
    return TwoAxis(structure=structure, numbers=numbers, halves=(halves[0], halves[1]), effects=tuple(both))
