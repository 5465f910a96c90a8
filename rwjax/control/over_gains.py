"""Any criterion over many gains and many linear plants, by `vmap` in blocks.

A criterion is a plain JAX function of one vector of gains and one plant, such as `rwjax.control.poles.slowest_pole`. A plant is a PyTree of
arrays, many plants the same tree with a first axis. For the nonlinear closed loop over gains see `rwjax.sweep`.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

BLOCK = 200
"""Gains, or plants, that are computed side by side: the memory that is needed does not grow with their number."""
Criterion = Callable[[Float[Array, " g"], Any], Any]
"""Numbers of any unit from one vector of gains and one plant."""


@partial(jax.jit, static_argnums=0)
def over_gains(criterion: Criterion, gains: Float[Array, "*grid g"], plant: Any) -> Any:
    """A criterion at every vector of gains. It compiles once for each criterion.

    Args:
        criterion: A function of one vector of gains and one plant.
        gains: Vectors of gains [any unit] along the last axis: a list `(k, g)`, or a grid of any shape.
        plant: The plant.

    Returns:
        What the criterion gives [any unit], with the axes of the grid first.
    """
    grid, flat = gains.shape[:-1], gains.reshape(-1, gains.shape[-1])
    found = jax.lax.map(lambda one: criterion(one, plant), flat, batch_size=BLOCK)
    return jax.tree.map(lambda x: x.reshape(*grid, *x.shape[1:]), found)


def gain_grid(*axes: np.ndarray) -> Float[np.ndarray, "*grid g"]:
    """Every combination of some gains.

    Args:
        *axes: The values of each gain [any unit].

    Returns:
        The vectors of gains [any unit] along the last axis, one axis of the grid before it for each gain.
    """
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1)


@partial(jax.jit, static_argnums=0)
def over_plants(criterion: Criterion, gains: Float[Array, " g"], plants: Any) -> Any:
    """A criterion of one vector of gains at every plant; over gains too, `over_gains(partial(over_plants, criterion), gains, plants)`.

    Args:
        criterion: A function of one vector of gains and one plant.
        gains: The vector of gains [any unit].
        plants: The plants, all their arrays with a first axis.

    Returns:
        What the criterion gives [any unit], with a first axis of plants.
    """
    return jax.lax.map(lambda one: criterion(gains, one), plants, batch_size=BLOCK)
