"""The aliases of signatures, as beartype reads them, and the entries of a vector."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from beartype.door import is_bearable

from rwjax.types import Scalar, entries

X = np.array([1.0, -2.0, 0.5])


@pytest.mark.parametrize(
    ("value", "fits"),
    [
        (lambda: jnp.zeros(()), True),
        (lambda: jnp.zeros(1), False),
        (lambda: jnp.zeros((), int), False),
        (lambda: 0.0, False),
    ],
    ids=["one number", "a vector", "a whole number", "no array"],
)
def test_a_scalar_is_an_array_without_axes(value: Callable[[], object], fits: bool) -> None:
    assert is_bearable(value(), Scalar) == fits


def test_entries_are_the_numbers_in_their_order() -> None:
    found = entries(jnp.asarray(X))
    assert [float(x) for x in found] == X.tolist() and all(x.shape == () for x in found)


def test_a_single_entry_and_a_slope() -> None:
    assert [float(x) for x in entries(jnp.asarray(X[:1]))] == [1.0]
    slope = jax.grad(lambda x: entries(x)[1] ** 2)(jnp.asarray(X))
    assert np.array_equal(slope, [0.0, -4.0, 0.0])
