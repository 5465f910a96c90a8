"""Dry friction on bodies that push one another: the complementarity problem."""

import jax
import jax.numpy as jnp
import numpy as np

from rwjax.plant.coupled_friction import friction_of_resting, mobility_with_held, solve_within


def test_friction_on_resting_bodies_solves_the_complementarity_problem() -> None:
    """Random mobilities, levels and torques; changing all bodies at once, 1 in 40 of them would run in circles."""
    rng = np.random.default_rng(3)
    n = 20_000
    root = rng.normal(size=(n, 4, 4)) * 10.0 ** rng.uniform(-1.0, 1.0, size=(n, 1, 4))
    G = np.einsum("nij,nkj->nik", root, root) + 1e-2 * np.eye(4)
    free, resting = np.einsum("nij,nj->ni", G, rng.normal(size=(n, 4))), rng.random((n, 4)) < 0.8
    ahead, back = rng.exponential(0.7, size=(2, n, 4))
    sliding = np.where(resting, 0.0, np.where(rng.random((n, 4)) < 0.5, ahead, -back))
    f, held = jax.vmap(friction_of_resting)(*map(jnp.asarray, (G, free, sliding, resting, ahead, back)))
    f, held = np.asarray(f), np.asarray(held)
    a = free - np.einsum("nij,nj->ni", G, f)
    assert np.all((-back <= f) & (f <= ahead))
    small = np.abs(a) < 1e-8 * np.einsum("nii->n", G)[:, None]
    fine = small | np.where(a > 0.0, f == ahead, f == -back) | ~resting
    assert np.all(small[held]) and 0.2 < held[resting].mean() < 0.8
    assert np.all(fine), np.sum(~fine.all(axis=1))


def test_a_small_system_is_solved_for_some_bodies_alone() -> None:
    rng = np.random.default_rng(0)
    root = rng.normal(size=(4, 4))
    G, b, inside = root @ root.T + np.eye(4), rng.normal(size=4), np.array([True, False, True, True])
    found = solve_within(jnp.asarray(G), jnp.asarray(b), jnp.asarray(inside))
    expected = np.zeros(4)
    expected[inside] = np.linalg.solve(G[np.ix_(inside, inside)], b[inside])
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_the_mobility_beside_held_bodies_is_that_of_the_mass_matrix_without_them() -> None:
    rng = np.random.default_rng(1)
    root = rng.normal(size=(4, 4))
    mass, held = root @ root.T + np.eye(4), np.array([False, True, False, False])
    found = np.asarray(mobility_with_held(jnp.asarray(np.linalg.inv(mass)), jnp.asarray(held)))
    free = ~held  # a held body is a row and a column less
    np.testing.assert_allclose(found[free], np.diag(np.linalg.inv(mass[np.ix_(free, free)])), rtol=1e-12)
    np.testing.assert_allclose(found[held], np.diag(np.linalg.inv(mass))[held], rtol=1e-12)
