"""Criteria over gains and plants in blocks: what a loop over them finds."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.control.linear import Linear
from rwjax.control.over_gains import BLOCK, gain_grid, over_gains, over_plants
from rwjax.control.poles import slowest_pole

KP, KD = np.linspace(0.0, 9.0, 15), np.linspace(0.0, 4.0, 18)  # more pairs than a block, and no multiple of one


def plant(friction: float) -> Linear:
    """s² + friction s: its poles under PD control are those of s² + (friction + kd) s + kp."""
    return Linear(np.array([[0.0, 1.0], [0.0, -friction]]), np.array([0.0, 1.0]), np.array([1.0, 0.0]))


def slowest(kp: float, kd: float, friction: float) -> float:
    return float(np.max(np.roots([1.0, friction + kd, kp]).real))


def test_a_grid_keeps_its_shape() -> None:
    grid = gain_grid(KP, KD)
    assert grid.shape == (15, 18, 2) and grid[3, 5].tolist() == [KP[3], KD[5]] and BLOCK < 15 * 18
    expected = [[slowest(kp, kd, 0.3) for kd in KD] for kp in KP]
    assert over_gains(slowest_pole, grid, plant(0.3)) == pytest.approx(np.array(expected), abs=1e-7)
    assert over_gains(slowest_pole, grid[3], plant(0.3)) == pytest.approx(np.array(expected[3]), abs=1e-7)


def test_many_plants_and_many_gains_are_every_pair_of_them() -> None:
    friction = np.linspace(0.0, 2.0, BLOCK + 3)
    plants = jax.tree.map(lambda *x: np.stack(x), *map(plant, friction))
    gains = gain_grid(KP[1:3], KD[:2])
    found = over_gains(partial(over_plants, slowest_pole), gains, plants)
    assert found.shape == (2, 2, BLOCK + 3)
    for i, j, k in [(0, 1, 0), (1, 0, 70), (1, 1, BLOCK), (0, 0, BLOCK + 2)]:
        assert float(found[i, j, k]) == pytest.approx(slowest(KP[1 + i], KD[j], friction[k]), abs=1e-7)
    worst = over_gains(lambda gains, plants: jnp.max(over_plants(slowest_pole, gains, plants)), gains, plants)
    assert np.array_equal(worst, np.max(found, axis=-1))


def test_a_criterion_of_ones_own_may_give_several_numbers_and_take_any_plant() -> None:
    def stretched(gains: jax.Array, plant: dict) -> dict:
        return {"sum": jnp.sum(gains) * plant["scale"], "pair": gains[::-1]}

    found = over_gains(stretched, gain_grid(KP, KD, KD[:2]), {"scale": 2.0})
    assert found["sum"].shape == (15, 18, 2) and found["pair"].shape == (15, 18, 2, 3)
    assert float(found["sum"][2, 3, 1]) == pytest.approx(2.0 * (KP[2] + KD[3] + KD[1]))
    assert found["pair"][2, 3, 1].tolist() == [KD[1], KD[3], KP[2]]


def test_memory_does_not_grow_with_the_grid() -> None:
    few, many = (
        over_gains.lower(slowest_pole, np.ones((blocks * BLOCK, 2)), plant(0.3)).compile().memory_analysis()
        for blocks in (2, 50)
    )
    assert few is not None and many is not None
    assert many.temp_size_in_bytes == few.temp_size_in_bytes > 0


def test_derivatives_go_through_the_sweep() -> None:
    """The slope of the summed damping: each pair that rings has its poles' real part at -(friction + kd) / 2."""

    def total(friction: jax.Array) -> jax.Array:
        own = plant(0.0)
        return jnp.sum(
            over_gains(
                slowest_pole, gain_grid(KP[5:], KD[:5]), own._replace(A=jnp.asarray(own.A).at[1, 1].set(-friction))
            )
        )

    assert float(jax.grad(total)(jnp.asarray(0.1))) == pytest.approx(-0.5 * 50)
