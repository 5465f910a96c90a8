"""Effects on the axis: the friction that a rig file models and the friction that may be missing, written once."""

from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.ports import AxisDry, AxisTorque, Motion
from rwjax.param import param
from rwjax.types import Scalar


class Viscous(AxisTorque):
    r"""Friction proportional to speed, $M = b\,w$ (thesis eq. 3.4)."""

    name: ClassVar[str] = "axis.viscous"
    label: ClassVar[str] = "viscous friction"
    coordinate: ClassVar[str] = "yaw_rate"
    b: Scalar = param("N m s/rad", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque_per_rate", tex="b")

    def torque(self, motion: Motion) -> Scalar:
        return -self.b * motion.w


class Coulomb(AxisDry):
    r"""Dry friction, constant with direction, $M = M_c\,\mathrm{sgn}\,w$ (thesis eq. 3.7)."""

    name: ClassVar[str] = "axis.coulomb"
    label: ClassVar[str] = "dry friction"
    coordinate: ClassVar[str] = "yaw_rate"
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.05, 0.3), scale="torque", tex="M_c")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c


class Stribeck(AxisDry):
    r"""Breakaway friction above sliding friction, $M = [M_c + M_e\,e^{-(w/v_s)^2}]\,\mathrm{sgn}\,w$.

    $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise; the breakaway level is $M_c + M_e$.
    Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), eq. 8 with exponent 2.
    """

    name: ClassVar[str] = "axis.stribeck"
    label: ClassVar[str] = "Stribeck friction"
    coordinate: ClassVar[str] = "yaw_rate"
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    M_e: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_s - M_c")
    v_s: Scalar = param("rad/s", bounds=(1e-3, 1e2), null=1.0, starts=(0.03, 0.1, 0.3), scale="rate", tex="v_s")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c + self.M_e * jnp.exp(-((motion.w / self.v_s) ** 2))


class AsymmetricFriction(AxisDry):
    r"""Dry friction that differs with direction, $M = (M_c + d\,\mathrm{sgn}\,w)\,\mathrm{sgn}\,w$.

    $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise.
    """

    name: ClassVar[str] = "axis.asymmetric_friction"
    label: ClassVar[str] = "direction-dependent dry friction"
    coordinate: ClassVar[str] = "yaw_rate"
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    d: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, -0.03), scale="torque", tex="d")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c + direction * self.d


class PolynomialFriction(AxisDry):
    r"""Friction polynomial of a rig file, $M = (b_3 + b_2|w| + b_1 w^2 + b_0 |w|^3)\,\mathrm{sgn}\,w$ (thesis eq. 4.7)."""

    name: ClassVar[str] = "axis.polynomial"
    label: ClassVar[str] = "polynomial friction"
    coordinate: ClassVar[str] = "yaw_rate"
    b3: Scalar
    b2: Scalar
    b1: Scalar
    b0: Scalar

    def level(self, motion: Motion, direction: float) -> Scalar:
        w = direction * motion.w
        return self.b3 + w * (self.b2 + w * (self.b1 + w * self.b0))


class Gravity(AxisTorque):
    r"""Known load of an off-centre mass, $M_g = m g l \sin(\psi + \varphi)$, subtracted from the driving torque."""

    name: ClassVar[str] = "axis.gravity"
    label: ClassVar[str] = "gravity"
    coordinate: ClassVar[str] = "yaw"
    mgl: Scalar
    angle: Scalar

    def torque(self, motion: Motion) -> Scalar:
        return -self.mgl * jnp.sin(motion.psi + self.angle)


class BiasTorque(AxisTorque):
    r"""Constant torque $T$ on the axis; positive turns it forward."""

    name: ClassVar[str] = "axis.bias_torque"
    label: ClassVar[str] = "constant torque"
    coordinate: ClassVar[str] = "load"
    T: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, -0.03), scale="torque", tex="T")

    def torque(self, motion: Motion) -> Scalar:
        return self.T
