"""Rates of a plant along a given motion."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from rwjax.plant.assemble import plant_of
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.structure import Structure
from rwjax.types import Scalar


@partial(jax.jit, static_argnames="structure")
def rates_along(
    structure: Structure,
    theta: Float[Array, " p"],
    t: Float[Array, " t"],
    states: Float[Array, "t n"],
    command: Float[Array, "t *channels"],
    on: Bool[Array, " t"] | None = None,
) -> Float[Array, "t n"]:
    """Rates of all states along a motion, dry friction included; a body at speed 0 feels what would hold it.

    Args:
        structure: What the plant is made of.
        theta: Its numbers `(p,)` [SI].
        t: Times since the run's first sample `(t,)` [s].
        states: States at these times `(t, n)` [SI].
        command: Command before the drive at these times `(t,)` or `(t, 2)` [V].
        on: Whether current can flow at these times `(t,)`; None where it always can.

    Returns:
        Rates `(t, n)` [SI].
    """
    plant = plant_of(structure, theta)

    def one(t: Scalar, x: Float[Array, " n"], u: Float[Array, "*channels"], on: Any) -> Float[Array, " n"]:
        at = plant.powered(on.astype(x.dtype)) if isinstance(plant, OneAxis) and on is not None else plant
        state = tuple(x[k] for k in range(len(structure.states)))
        return jnp.stack(at.with_friction(t, state, at.act(u), state).rates)

    return jax.vmap(one, in_axes=(0, 0, 0, None if on is None else 0))(t, states, command, on)
