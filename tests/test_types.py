"""The entries of a vector as scalars."""

import jax
import jax.numpy as jnp
import numpy as np

from rwjax.types import entries

X = np.array([1.0, -2.0, 0.5])


def test_entries_are_the_numbers_in_their_order() -> None:
    found = entries(jnp.asarray(X))
    assert [float(x) for x in found] == X.tolist() and all(x.shape == () for x in found)


def test_a_single_entry_and_its_slope() -> None:
    assert [float(x) for x in entries(jnp.asarray(X[:1]))] == [1.0]
    slope = jax.grad(lambda x: entries(x)[1] ** 2)(jnp.asarray(X))
    assert np.array_equal(slope, [0.0, -4.0, 0.0])
