"""Delays of a rig itself: of the commands that act, and of the readings that a controller gets."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar


class Delays(NamedTuple):
    """Delays of one or many plants.

    Attributes:
        commands: Time from a command to its action [s], `(k,)`.
        readings: Age of the encoder's reading [s], `(k,)`.
    """

    commands: Float[np.ndarray, " k"]
    readings: Float[np.ndarray, " k"]

    @property
    def loop(self) -> Float[np.ndarray, " k"]:
        """Sum of both [s], `(k,)`: from one reading to the next a loop knows nothing else."""
        return self.commands + self.readings


def delays_of(rig: Rig, thetas: Float[np.ndarray, "k p"] | None = None) -> Delays:
    """Delays of a rig, or of many plants of its structure.

    Args:
        rig: The rig.
        thetas: Parameter vectors [SI], one plant for each row, `(k, p)`; without them the rig itself counts, k = 1.

    Returns:
        Delays [s] of commands and readings, `(k,)` each.
    """
    structure = structure_of(rig)
    rows = theta_of(rig, structure)[None] if thetas is None else np.asarray(thetas)
    commands, readings = _delays(structure, rows)
    return Delays(np.asarray(commands), np.asarray(readings))


@partial(jax.jit, static_argnums=0)
def _delays(structure: Structure, rows: Float[Array, "k p"]) -> tuple[Array, Array]:
    """Delays [s] of commands and readings, `(k,)` each, of plants with the parameter vectors `rows`."""

    def of(theta: Float[Array, " p"]) -> tuple[Scalar, Scalar]:
        plant = one_axis_plant_of(structure, theta)
        command, reading = (jnp.zeros(()) if time is None else time for time in (plant.delay(), plant.age()))
        return command, reading

    return jax.vmap(of)(rows)
