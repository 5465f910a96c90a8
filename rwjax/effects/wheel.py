"""Effects between wheel and body."""

from collections.abc import Mapping
from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.effect import Motion
from rwjax.effects.harmonics import with_overtone
from rwjax.effects.parameter import param
from rwjax.effects.ports import WheelDry, WheelTorque
from rwjax.effects.shown import COASTING, SLOW
from rwjax.types import Scalar


class WheelCoulomb(WheelDry):
    r"""Dry friction in the wheel's bearing, $M = M_c\,\mathrm{sgn}\,\Omega$.

    Attributes:
        M_c: Level of the friction [N m].
    """

    name: ClassVar[str] = "wheel.coulomb"
    label: ClassVar[str] = "dry friction of the wheel"
    coordinate: ClassVar[str] = "wheel_rate"
    meaning: ClassVar[str] = "dry friction in the wheel's bearing"
    equation: ClassVar[str] = "M_c sgn Ω"
    shown_by: ClassVar[Mapping[str, int]] = {COASTING: 0}
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.03, 0.2), scale="torque", tex="M_{c}")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"wheel_frictionloss": given["M_c"]}


class WheelDrag(WheelTorque):
    r"""Air drag of the wheel, $M = c\,\Omega|\Omega|$.

    Attributes:
        c: Torque per rate squared [N m s²/rad²].
    """

    name: ClassVar[str] = "wheel.drag"
    label: ClassVar[str] = "air drag of the wheel"
    coordinate: ClassVar[str] = "wheel_rate"
    light: ClassVar[bool] = True
    equation: ClassVar[str] = "c Ω abs(Ω)"
    shown_by: ClassVar[Mapping[str, int]] = {COASTING: 0}
    c: Scalar = param("N m s2/rad2", bounds=(0.0, jnp.inf), starts=(0.05,), scale="torque_per_spin2", tex="c")

    def torque(self, motion: Motion) -> Scalar:
        return -self.c * motion.Omega * jnp.abs(motion.Omega)


ORDERS = tuple(map(float, range(2, 15)))
"""Ripples in a turn at which cogging is searched."""


class Cogging(WheelTorque):
    r"""Torque ripple with the wheel's angle, $M = s\sin n\theta + c\cos n\theta$ and its overtone.

    The overtone is $(p s - q c)\sin 2n\theta + (p c + q s)\cos 2n\theta$.

    Attributes:
        s: Amplitude of the sine [N m].
        c: Amplitude of the cosine [N m].
        n: Ripples in a turn [1].
        p: Overtone in phase, over the first harmonic [1].
        q: Overtone a quarter of a turn apart, over the first harmonic [1].
    """

    name: ClassVar[str] = "wheel.cogging"
    label: ClassVar[str] = "cogging of the motor"
    coordinate: ClassVar[str] = "wheel_angle"
    at_angle: ClassVar[bool] = True
    meaning: ClassVar[str] = "torque ripple with the wheel's angle"
    equation: ClassVar[str] = (
        "drives the wheel with s sin nθ + c cos nθ and an overtone, (p s − q c) sin 2nθ + (p c + q s) cos 2nθ"
    )
    shown_by: ClassVar[Mapping[str, int]] = {SLOW: 0}
    comes_and_goes: ClassVar[bool] = True
    linear_as: ClassVar[str | None] = ""
    s: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, 0.0) * len(ORDERS), scale="torque", tex="s")
    c: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.03) * len(ORDERS), scale="torque", tex="c")
    n: Scalar = param(
        "1", bounds=(1.0, 48.0), null=6.0, starts=tuple(n for order in ORDERS for n in (order, order)), tex="n"
    )

    p: Scalar = param("1", bounds=(-1.0, 1.0), starts=(0.0,), tex="p", role="form")
    q: Scalar = param("1", bounds=(-1.0, 1.0), starts=(0.0,), tex="q", role="form")

    def torque(self, motion: Motion) -> Scalar:
        return with_overtone(self.n * motion.theta, self.s, self.c, self.p, self.q)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "no ripple holds the wheel"
