"""Effects between wheel and body."""

from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.ports import Motion, WheelDry
from rwjax.param import param
from rwjax.types import Scalar


class WheelCoulomb(WheelDry):
    r"""Dry friction in the wheel's bearing, $M = M_c\,\mathrm{sgn}\,\Omega$."""

    name: ClassVar[str] = "wheel.coulomb"
    label: ClassVar[str] = "dry friction of the wheel"
    coordinate: ClassVar[str] = "wheel_rate"
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.03, 0.2), scale="torque", tex="M_{c}")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c
