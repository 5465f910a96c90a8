"""Laws outside the list of effects: no rig file holds one, and no answer claims one. Each passes for an effect, which it is told from before that is claimed."""

from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.effect import Motion
from rwjax.effects.harmonics import two_harmonics
from rwjax.effects.parameter import param
from rwjax.effects.ports import AxisAgeing, AxisDry, AxisTorque, Inertia
from rwjax.types import Scalar


class GrowingStiction(AxisAgeing):
    r"""Breakaway friction that grows with the time at rest, $M = M_c + M_e\,(1 - e^{-t_r/\tau})$; $M_c$ alone while sliding.

    $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise. Kato, Sato and Matsubayashi (1972), with the exponent 1.

    Attributes:
        M_c: Level of sliding friction; 0 where dry friction is modelled elsewhere [N m].
        M_e: Breakaway level above that of sliding after a long rest [N m].
        tau: Time at rest in which it grows [s].
    """

    name: ClassVar[str] = "axis.growing_stiction"
    label: ClassVar[str] = "breakaway friction that grows with the time at rest"
    coordinate: ClassVar[str] = "time"
    equation: ClassVar[str] = "(M_c + M_e (1 − exp(−t_r/τ))) sgn w, t_r the time at rest"
    includes: ClassVar[str] = "axis.coulomb"
    passes_for: ClassVar[tuple[str, ...]] = ("axis.stribeck",)
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    M_e: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1, 0.2, 0.4) * 3, scale="torque", tex="M_e")
    tau: Scalar = param("s", bounds=(1e-2, 1e2), null=1.0, starts=(*(0.1,) * 3, *(0.3,) * 3, *(1.0,) * 3), tex="\\tau")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c + self.M_e * (1.0 - jnp.exp(-self.mine(motion)[0] / self.tau))


class WorkedFriction(AxisDry):
    r"""Dry friction that changes with how fast the axis has turned of late: a factor $1 + d\,v$ on all other, $\tau\dot v = |w| - v$.

    So a bearing warms up that its own friction heats, and cools at rest.

    Attributes:
        d: Share by which friction changes per rate of late [s/rad].
        tau: Time over which it does [s].
    """

    name: ClassVar[str] = "axis.worked_friction"
    label: ClassVar[str] = "friction that changes with how fast the axis has turned of late"
    coordinate: ClassVar[str] = "time"
    equation: ClassVar[str] = "all other dry friction times max(1 + d v, 0), τ v' = abs(w) − v"
    states: ClassVar[tuple[str, ...]] = ("v",)
    passes_for: ClassVar[tuple[str, ...]] = ("axis.friction_drift",)
    d: Scalar = param("s/rad", bounds=(-jnp.inf, jnp.inf), starts=(-0.5, 1.0, 3.0) * 2, scale="per_rate", tex="d")
    tau: Scalar = param("s", bounds=(1e-2, 1e3), null=1.0, starts=(*(0.7,) * 3, *(5.0,) * 3), tex="\\tau")

    def drift(self, motion: Motion) -> tuple[Scalar, ...]:
        return ((jnp.abs(motion.w) - self.mine(motion)[0]) / self.tau,)

    def level(self, motion: Motion, direction: float) -> Scalar:
        return jnp.zeros(())

    def share(self, motion: Motion) -> Scalar:
        return jnp.maximum(self.d * self.mine(motion)[0], -1.0)


class GrowingInertia(Inertia):
    r"""What the torque is divided by grows with the rate: $I\,(1 + p\,(1 - e^{-(w/w_0)^2}))\,\dot w = M$, as where a fluid is taken along.

    It acts on the axis, behind an elastic coupling on the side of the load, and on the wheel where there is no axis.

    Attributes:
        p: Share by which it is larger at high speed [1].
        w_0: Rate about which it grows [rad/s].
    """

    name: ClassVar[str] = "axis.growing_inertia"
    label: ClassVar[str] = "an inertia that grows with the speed"
    coordinate: ClassVar[str] = "yaw_rate"
    equation: ClassVar[str] = "I (1 + p (1 − exp(−(w/w_0)²))) w' = M"
    passes_for: ClassVar[tuple[str, ...]] = ("sensor.missed_counts",)
    p: Scalar = param("1", bounds=(0.0, 1e2), starts=(0.1, 0.3, 1.0) * 2, tex="p")
    w_0: Scalar = param(
        "rad/s", bounds=(1e-6, 1e5), null=1.0, starts=(*(0.4,) * 3, *(0.8,) * 3), scale="sensed_rate", tex="w_0"
    )

    def factor(self, w: Scalar) -> Scalar:
        return 1.0 - self.p * jnp.expm1(-((w / self.w_0) ** 2))


class AngleGain(AxisTorque):
    r"""A gain that goes with the angle: $M_d\,(s_1\sin\psi + c_1\cos\psi + s_2\sin 2\psi + c_2\cos 2\psi)$ is driven besides.

    $M_d$ is the torque that the drive transmits. So a crank, an eccentric pulley or a motor whose constant goes with its angle drives. A
    reaction wheel does not feel it: there it is a torque on the body alone.

    Attributes:
        s_1: Sine of the angle in the gain, over its mean [1].
        c_1: Cosine of the angle [1].
        s_2: Sine of twice the angle [1].
        c_2: Cosine of twice the angle [1].
    """

    name: ClassVar[str] = "axis.angle_gain"
    label: ClassVar[str] = "a gain that goes with the angle"
    coordinate: ClassVar[str] = "yaw"
    equation: ClassVar[str] = "drives with M_d (s_1 sin ψ + c_1 cos ψ + s_2 sin 2ψ + c_2 cos 2ψ)"
    at_angle: ClassVar[bool] = True
    passes_for: ClassVar[tuple[str, ...]] = (
        "axis.imbalance",
        "axis.spring",
        "axis.angle_friction",
        "axis.periodic_torque",
    )
    s_1: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.2, 0.0, 0.0, 0.0), tex="s_1")
    c_1: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.2, 0.0, 0.0), tex="c_1")
    s_2: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.0, 0.2, 0.0), tex="s_2")
    c_2: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.0, 0.0, 0.2), tex="c_2")

    def torque(self, motion: Motion) -> Scalar:
        return motion.load * two_harmonics(motion.psi, self.s_1, self.c_1, self.s_2, self.c_2)
