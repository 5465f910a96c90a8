"""Plants that share a program of free runs: they differ by light effects alone, which the program holds at their nulls."""

from functools import cache

import numpy as np
from jaxtyping import Float

from rwjax.effects.library import BY_NAME, LIBRARY, of_kind
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import AxisDry
from rwjax.plant.structure import Structure
from rwjax.simulation.batch import Batch


@cache
def with_light_effects(structure: Structure) -> Structure:
    """The structure whose program serves a plant: with every light effect of the library (`Effect.light`) that it may have.

    Dry friction joins no plant that has none among its effects of that part: a body without any takes half the time.

    Args:
        structure: What the plant is made of.

    Returns:
        A structure with the same states and outputs.
    """
    rubbed = {_part(name) for name in structure.effects if issubclass(BY_NAME[name], AxisDry)}

    def joins(name: str) -> bool:
        light = BY_NAME[name].light and BY_NAME[name] in LIBRARY
        return light and (_part(name) in rubbed or not issubclass(BY_NAME[name], AxisDry))

    return structure.with_effects(*filter(joins, of_kind(structure.kind)))


def numbers_within(
    program: Structure, structure: Structure, numbers: Float[np.ndarray, "b p"]
) -> Float[np.ndarray, "b q"]:
    """Numbers of plants in a structure that has further effects.

    Args:
        program: The structure that has them, by `with_light_effects`, or the plants' own.
        structure: What the plants are made of.
        numbers: Numbers of each plant in the order of the structure's names `(b, p)` [SI].

    Returns:
        Numbers `(b, q)` in the order of the larger structure's names [SI], those of what is added at their nulls.
    """
    nulls, own = _places(program, structure)
    found = np.tile(nulls, (len(numbers), 1))
    found[:, own] = numbers
    return found


def batch_within(
    program: Structure, structure: Structure, theta: Float[np.ndarray, " t"], batch: Batch
) -> tuple[Float[np.ndarray, " u"], Batch]:
    """Numbers of several logs in a structure that has further effects.

    Args:
        program: The structure that has them, by `with_light_effects`, or the plant's own.
        structure: What the plant is made of.
        theta: Numbers of all logs `(t,)` [SI].
        batch: The logs.

    Returns:
        The numbers with the nulls of what is added behind them [SI], and the logs with their numbers in the order of the larger
        structure's names.
    """
    nulls, own = _places(program, structure)
    index = np.tile(len(theta) + np.arange(len(nulls)), (len(batch.theta_index), 1))
    offset = np.zeros(index.shape)
    index[:, own], offset[:, own] = batch.theta_index, batch.theta_offset
    return np.concatenate([theta, nulls]), batch._replace(theta_index=index, theta_offset=offset)


@cache
def _places(program: Structure, structure: Structure) -> tuple[np.ndarray, np.ndarray]:
    """Nulls of the larger structure's numbers, 0 for the base numbers, and where a structure's own stand among them."""
    of_effects = ((f"{e}.{n}", p.null) for e in BY_NAME for n, p in parameters(BY_NAME[e]).items())
    null, names = dict(of_effects), program.names
    return np.array([null.get(name, 0.0) for name in names]), np.array([names.index(n) for n in structure.names], int)


def _part(name: str) -> str:
    """The part of a rig on which an effect acts."""
    return name.partition(".")[0]
