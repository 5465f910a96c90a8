"""The plant of any kind of rig, from its structure and its numbers."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from rwjax.plant.one_axis import OneAxis, one_axis
from rwjax.plant.plant import Plant
from rwjax.plant.structure import Numbers, Structure
from rwjax.plant.two_axis import two_axis
from rwjax.rig.tied import evaluate, names_in
from rwjax.types import entries


def assemble(structure: Structure, numbers: Numbers) -> Plant:
    """Plant of a structure with these numbers.

    Args:
        structure: What the plant is made of.
        numbers: Value of every name of `structure.names` [SI].

    Returns:
        The plant.
    """
    return two_axis(structure, numbers) if structure.kind == "two_axis" else one_axis(structure, numbers)


def plant_of(structure: Structure, theta: Float[Array, " p"]) -> Plant:
    """Plant with the numbers of a parameter vector.

    Args:
        structure: What the plant is made of.
        theta: Values `(p,)` in the order of `structure.names` [SI].

    Returns:
        The plant.
    """
    return assemble(structure, _numbers(structure, theta))


def one_axis_plant_of(structure: Structure, theta: Float[Array, " p"]) -> OneAxis:
    """`plant_of` for a rig with one axis or none.

    Args:
        structure: What the plant is made of.
        theta: Values `(p,)` in the order of `structure.names` [SI].

    Returns:
        The plant.
    """
    return one_axis(structure, _numbers(structure, theta))


def _numbers(structure: Structure, theta: Float[Array, " p"]) -> Numbers:
    """Numbers by name; those that follow from others by their formulas, whatever the vector says of them."""
    numbers: Numbers = dict(zip(structure.names, entries(theta), strict=True))
    for name, formula in structure.tied:
        if name in numbers and {*names_in(formula)} <= numbers.keys():  # a linearised plant may lack effects
            numbers[name] = evaluate(formula, numbers, jnp)
    return numbers
