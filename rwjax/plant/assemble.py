"""The plant of any kind of rig."""

from rwjax.plant.one_axis import Numbers, Plant, Structure, one_axis
from rwjax.plant.two_axis import TwoAxis, two_axis

AnyPlant = Plant | TwoAxis


def assemble(structure: Structure, numbers: Numbers) -> AnyPlant:
    """Plant of a structure with these numbers (all names of `structure.names` must be there)."""
    return two_axis(structure, numbers) if structure.kind == "two_axis" else one_axis(structure, numbers)
