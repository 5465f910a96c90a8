"""What a program says that is not lowered."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.lowering.emitter import Unsupported
from tests.lowering.lowered import agrees

X = np.random.default_rng(4).normal(size=(10, 30))


def test_what_is_not_lowered_says_what_it_is() -> None:
    with pytest.raises(Unsupported, match="sort"):
        agrees(jnp.sort, X)
