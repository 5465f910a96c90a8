"""Effects in the motor's winding and its driver."""

from collections.abc import Mapping
from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.effect import Motion
from rwjax.effects.parameter import param
from rwjax.effects.ports import CurrentLimit, MotorTorque, Winding
from rwjax.effects.shown import LEVELS
from rwjax.types import Scalar


class Heating(Winding):
    r"""Resistance that rises as the winding warms, $R(1 + q)$ with $\dot q = c\,i^2(1 + q) - q/\tau$: the risen resistance heats, too.

    Attributes:
        c: Rise of the resistance per second and current squared, over the cold one [1/(A² s)].
        tau: Time constant of cooling [s].
    """

    name: ClassVar[str] = "motor.heating"
    label: ClassVar[str] = "winding that warms up"
    coordinate: ClassVar[str] = "current"
    states: ClassVar[tuple[str, ...]] = ("q",)
    meaning: ClassVar[str] = "resistance that rises as the winding warms"
    equation: ClassVar[str] = "R (1 + q), q' = c i² (1 + q) − q/τ"
    c: Scalar = param("1/(A2 s)", bounds=(0.0, jnp.inf), starts=(0.02, 0.02), scale="per_ampere2", tex="c")
    tau: Scalar = param("s", bounds=(0.1, 1e4), null=30.0, starts=(30.0, 8.0), tex="\\tau")

    def drift(self, motion: Motion) -> tuple[Scalar, ...]:
        q = self.mine(motion)[0]
        return (self.c * motion.i**2 * (1.0 + q) - q / self.tau,)

    def resistance(self, motion: Motion) -> Scalar:
        return 1.0 + self.mine(motion)[0]

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "as at the first instant, the winding cold"


class Saturation(MotorTorque):
    r"""Torque per ampere that falls with the current, $K_e = K\,(1 + a\,i^2)^{-m}$; with $m = 1/2$ the torque itself has a limit.

    Attributes:
        a: Inverse of the square of the current from which on it falls [1/A²]; with m = 1 half the torque is left there.
        m: How fast it falls [1].
    """

    name: ClassVar[str] = "motor.saturation"
    label: ClassVar[str] = "saturation of the motor"
    coordinate: ClassVar[str] = "current"
    meaning: ClassVar[str] = "torque per ampere that falls with the current"
    equation: ClassVar[str] = "K (1 + a i²)^(−m)"
    shown_by: ClassVar[Mapping[str, int]] = {LEVELS: 3}
    a: Scalar = param("1/A2", bounds=(0.0, jnp.inf), starts=(0.1, 0.2), scale="per_ampere2", tex="a")
    m: Scalar = param("1", bounds=(0.25, 2.0), null=1.0, starts=(1.0, 0.5), tex="m", role="form")

    def factor(self, i: Scalar) -> Scalar:
        return (1.0 + self.a * i**2) ** -self.m

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "the gain is that of small commands"


class DriverLimit(CurrentLimit):
    r"""Current clipped by the driver, $|i| \le i_m$.

    Attributes:
        i_m: Largest current [A].
    """

    name: ClassVar[str] = "motor.current_limit"
    label: ClassVar[str] = "current limit of the driver"
    coordinate: ClassVar[str] = "current"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "current clipped by the driver"
    equation: ClassVar[str] = "abs(i) ≤ i_m"
    i_m: Scalar = param("A", bounds=(1e-6, 1e6), null=1e6, starts=(1.0, 0.8, 0.5), scale="peak_ampere", tex="i_m")

    def limit(self) -> Scalar:
        return self.i_m
