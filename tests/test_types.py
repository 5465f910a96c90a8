"""The aliases of signatures, as beartype reads them."""

from collections.abc import Callable

import jax.numpy as jnp
import pytest
from beartype.door import is_bearable

from rwjax.types import Scalar


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
