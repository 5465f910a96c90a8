"""Laws outside the list of effects: no rig file holds one, and no answer claims one. Each passes for an effect, which it is told from before that is claimed."""

from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.effect import Motion
from rwjax.effects.parameter import param
from rwjax.effects.ports import AxisAgeing
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
