"""The level of dry friction on one body, from all its friction effects together."""

from collections.abc import Sequence

import jax.numpy as jnp

from rwjax.effects.effect import Motion
from rwjax.effects.ports import AxisDry, Dry
from rwjax.types import Scalar


def friction_level(effects: Sequence[Dry], motion: Motion, direction: float) -> Scalar:
    """Dry friction on one body [N m], never below 0: `friction_sum` where that is positive.

    Args:
        effects: The dry friction effects on the body.
        motion: What the effects may depend on.
        direction: Direction of sliding, 1.0 or -1.0 [1].

    Returns:
        Level of the friction [N m].
    """
    return jnp.maximum(friction_sum(effects, motion, direction), 0.0)


def smooth_friction(effects: Sequence[Dry], motion: Motion, rate: Scalar, width: Scalar) -> Scalar:
    r"""Dry friction on one body with a smooth sign: its level times $\tanh(w/\text{width})$.

    Args:
        effects: The dry friction effects on the body.
        motion: What the effects may depend on.
        rate: Rate of the body, w [rad/s].
        width: Rate at which 76 % of the level acts [rad/s].

    Returns:
        Torque against the motion [N m].
    """
    level = jnp.where(rate > 0.0, friction_level(effects, motion, 1.0), friction_level(effects, motion, -1.0))
    return level * jnp.tanh(rate / width)


def friction_sum(effects: Sequence[Dry], motion: Motion, direction: float) -> Scalar:
    """Sum of all levels on one body, each raised by the shares of the others.

    Args:
        effects: The dry friction effects on the body.
        motion: What the effects may depend on.
        direction: Direction of sliding, 1.0 or -1.0 [1].

    Returns:
        The sum [N m], which may be negative.
    """
    own = [e.level(motion, direction) for e in effects]
    whole = sum(own, start=jnp.zeros_like(motion.t))
    raised = (
        e.share(motion) * (whole - level) for e, level in zip(effects, own, strict=True) if isinstance(e, AxisDry)
    )
    return sum(raised, start=whole)
