"""The plant of any kind of rig, from its structure and its numbers."""

from jaxtyping import Array, Float

from rwjax.plant.one_axis import OneAxis, one_axis
from rwjax.plant.plant import Plant
from rwjax.plant.structure import Numbers, Structure
from rwjax.plant.two_axis import two_axis


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
    return assemble(structure, {name: theta[k] for k, name in enumerate(structure.names)})


def one_axis_plant_of(structure: Structure, theta: Float[Array, " p"]) -> OneAxis:
    """`plant_of` for a rig with one axis or none.

    Args:
        structure: What the plant is made of.
        theta: Values `(p,)` in the order of `structure.names` [SI].

    Returns:
        The plant.
    """
    return one_axis(structure, {name: theta[k] for k, name in enumerate(structure.names)})
