"""The terms of the axis that a rig file models by its own numbers: known effects, which no diagnosis misses."""

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.axis_friction import Coulomb, Stribeck, Viscous
from rwjax.effects.c_code import literal
from rwjax.effects.effect import Effect, Motion
from rwjax.effects.ports import AxisDry, AxisTorque
from rwjax.kinds import COEFFICIENTS, HALVES, on_half
from rwjax.types import Scalar

_LEVELS = ("axis.friction.coulomb", "axis.friction.static", "axis.friction.b3")
LEVELS_IN_RIG = {*_LEVELS, *(on_half(name, k) for name in _LEVELS for k in range(len(HALVES)))}
"""Numbers of the rig file that give dry friction of an axis its level."""


class PolynomialFriction(AxisDry):
    r"""Friction polynomial of a rig file, $M = (b_3 + b_2|w| + b_1 w^2 + b_0 |w|^3)\,\mathrm{sgn}\,w$ (thesis eq. 4.7).

    Attributes:
        b3: Level of dry friction [N m].
        b2: Friction per rate [N m s/rad].
        b1: Friction per rate squared [N m s²/rad²].
        b0: Friction per rate cubed [N m s³/rad³].
    """

    name: ClassVar[str] = "axis.polynomial"
    mujoco_drops: ClassVar[Mapping[str, str]] = dict.fromkeys(("b1", "b0"), "its square and cube")
    label: ClassVar[str] = "polynomial friction"
    coordinate: ClassVar[str] = "yaw_rate"
    b3: Scalar
    b2: Scalar
    b1: Scalar
    b0: Scalar

    def level(self, motion: Motion, direction: float) -> Scalar:
        w = direction * motion.w
        return self.b3 + w * (self.b2 + w * (self.b1 + w * self.b0))

    @classmethod
    def c_level(cls, given: Mapping[str, float]) -> str:
        b3, b2, b1, b0 = (literal(given[b]) for b in ("b3", "b2", "b1", "b0"))
        return f"{b3} + w * ({b2} + w * ({b1} + w * {b0}))"

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"frictionloss": given["b3"], "damping": given["b2"]}


class Gravity(AxisTorque):
    r"""Known load of an off-centre mass, $M_g = m g l \sin(\psi + \varphi)$, subtracted from the driving torque.

    Attributes:
        mgl: Largest torque [N m].
        angle: Angle $\varphi$ [rad].
    """

    name: ClassVar[str] = "axis.gravity"
    label: ClassVar[str] = "gravity"
    coordinate: ClassVar[str] = "yaw"
    mgl: Scalar
    angle: Scalar

    def torque(self, motion: Motion) -> Scalar:
        return -self.mgl * jnp.sin(motion.psi + self.angle)

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"sine": given["mgl"] * math.cos(given["angle"]), "cosine": given["mgl"] * math.sin(given["angle"])}


def of_rig_numbers(numbers: Mapping[str, Scalar]) -> list[Effect]:
    """Friction and load of the axis that a rig file models by its own numbers.

    Args:
        numbers: Numbers by their names in the rig file of a rig with one axis (SI).

    Returns:
        The effects, in the order in which the plant adds them.
    """
    parts: list[Effect] = []
    if "axis.friction.viscous" in numbers:
        parts.append(Viscous(b=numbers["axis.friction.viscous"]))
    if "axis.friction.coulomb" in numbers:
        parts.append(Coulomb(M_c=numbers["axis.friction.coulomb"]))
    if "axis.friction.static" in numbers:
        parts.append(
            Stribeck(
                M_c=jnp.zeros_like(numbers["axis.friction.static"]),
                M_e=numbers["axis.friction.static"] - numbers.get("axis.friction.coulomb", jnp.zeros(())),
                v_s=numbers["axis.friction.stribeck_velocity"],
                n=2.0,
            )
        )
    if COEFFICIENTS[0] in numbers:
        parts.append(PolynomialFriction(*(numbers[name] for name in COEFFICIENTS)))
    if "axis.gravity.torque" in numbers:
        parts.append(Gravity(mgl=numbers["axis.gravity.torque"], angle=numbers["axis.gravity.angle"]))
    return parts


def terms_of(numbers: Mapping[str, float]) -> list[tuple[type[Effect], dict[str, float]]]:
    """The same with plain numbers, for what asks the effects' classes.

    Args:
        numbers: Numbers by their names in the rig file of a rig with one axis (SI).

    Returns:
        Each effect's class with its numbers by name (SI).
    """
    numbers = {"axis.gravity.angle": 0.0, **numbers}  # a file may leave it out
    found = of_rig_numbers({name: jnp.asarray(value) for name, value in numbers.items()})
    return [(type(effect), {f.name: float(getattr(effect, f.name)) for f in fields(effect)}) for effect in found]  # pyright: ignore[reportArgumentType] (parts are dataclasses)
