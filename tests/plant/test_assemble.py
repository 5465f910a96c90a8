"""The plant of any kind of rig."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.plant.assemble import assemble, one_axis_plant_of, plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.two_axis import TwoAxis
from rwjax.rig.model import Rig
from tests.systems import platform, reaction, wheel
from tests.two_axes import two_axis


@pytest.mark.parametrize("rig", [wheel(), platform(), reaction(), two_axis()], ids=lambda rig: rig.kind)
def test_every_kind_gets_its_plant_with_the_numbers_in_their_order(rig: Rig) -> None:
    structure = structure_of(rig)
    theta = 1.0 + np.arange(len(structure.names))
    plant = plant_of(structure, jnp.asarray(theta))
    assert isinstance(plant, TwoAxis if rig.kind == "two_axis" else OneAxis)
    for k, name in enumerate(structure.names):
        assert plant.numbers[name] == theta[k], name


def test_a_vector_and_a_table_of_numbers_make_the_same_plant() -> None:
    structure = structure_of(reaction())
    theta = theta_of(reaction(), structure)
    table = {name: jnp.asarray(v) for name, v in zip(structure.names, theta, strict=True)}
    x, t = tuple(jnp.asarray(v) for v in (0.1, 0.2, 0.3, 40.0, 0.5)), jnp.zeros(())
    one, other = assemble(structure, table), one_axis_plant_of(structure, jnp.asarray(theta))
    assert one.field(t, x, jnp.asarray(2.0)) == other.field(t, x, jnp.asarray(2.0))
