"""The interface that plants of all kinds share."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.plant import Plant, SmoothStep
from rwjax.rig.model import Rig
from tests.systems import platform, reaction, wheel
from tests.two_axes import GIMBAL, two_axis

LEVELS = '[effects."wheel_1.coulomb"]\nM_c = 0.01\n[yaw.friction]\ncoulomb = 0.01\n[pitch.friction]\ncoulomb = 0.01\n'
RIGS = [wheel(), platform(), reaction("coulomb = 0.01"), two_axis(GIMBAL + LEVELS)]


def of(rig: Rig) -> Plant:
    """The rig's plant."""
    structure = structure_of(rig)
    return plant_of(structure, jnp.asarray(theta_of(rig, structure)))


@pytest.mark.parametrize("rig", RIGS, ids=lambda rig: rig.kind)
def test_every_kind_rests_without_a_command(rig: Rig) -> None:
    plant, t = of(rig), jnp.zeros(())
    rest = tuple(jnp.zeros(()) for _ in plant.structure.states)
    found = plant.with_friction(t, rest, plant.no_command(), rest)
    assert not np.any(plant.field(t, rest, plant.no_command())) and not np.any(found.rates)
    assert all(float(torque.excess) == 0.0 for torque in found.torques)
    torques = [(torque, torque) for torque in found.torques]
    step = SmoothStep(t, rest, rest, plant.no_command(), jnp.asarray(0.01), found.rates, torques)
    assert not np.any(plant.settle(step))
    assert not np.any(plant.outputs(t, rest, plant.no_command()))


@pytest.mark.parametrize("rig", RIGS, ids=lambda rig: rig.kind)
def test_every_channel_of_the_command_has_its_drive(rig: Rig) -> None:
    plant = of(rig)
    u = jnp.arange(6.0).reshape(3, 2) if rig.kind == "two_axis" else jnp.arange(3.0)
    assert plant.no_command().shape == u.shape[1:]
    drives, commands = zip(*plant.channels(u), strict=True)
    assert len(drives) == (2 if rig.kind == "two_axis" else 1)
    assert np.array_equal(np.stack(commands, axis=-1).reshape(u.shape), u)
    assert [float(one.act(jnp.asarray(2.0))) for one in drives] == [2.0] * len(drives)
    assert plant.pace() == 1.0 and plant.age() is None
