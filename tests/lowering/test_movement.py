"""Primitives that move entries against JAX, in lanes and alone."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.lowering.lowered import agrees

X = np.random.default_rng(2).normal(size=(9, 6))
LONG = np.random.default_rng(3).normal(size=(9, 40))
CASES = {
    "turned": lambda x: (x[::-1], x.reshape(2, 3).T, x.reshape(3, 2)[::-1, 1], x[1:5:2], jnp.squeeze(x[None], 0)),
    "joined": lambda x: (jnp.concatenate([x[3:], x, x[:1]]), jnp.stack([x, 2.0 * x], axis=1), jnp.pad(x, (2, 1))),
    "split": lambda x: tuple(jnp.split(x, 3)),
    "unstacked": lambda x: tuple(jax.lax.unstack(x.reshape(2, 3), axis=1)),
    "repeated": lambda x: (jnp.broadcast_to(x[:, None], (6, 4)), jnp.outer(x, jnp.arange(3.0))),
    "window": lambda x: (
        jax.lax.dynamic_slice(x, (jnp.argmax(x),), (3,)),
        jax.lax.dynamic_index_in_dim(x, jnp.argmin(x)),
    ),
    "written": lambda x: (x.at[2].set(x[0]), jax.lax.dynamic_update_slice(x, x[:2] * 2.0, (jnp.argmax(x),))),
    "looked up": lambda x: (x[jnp.array([5, 0, 3])], x[(x > 0.0).astype(int)]),
}


@pytest.mark.parametrize("name", CASES)
def test_entries_are_moved_as_by_jax(name: str) -> None:
    assert agrees(CASES[name], X)


def test_long_arrays_are_moved_in_loops() -> None:
    def moved(x):
        joined = jnp.concatenate([x[20:], x[:20]])
        return joined, joined.reshape(8, 5).T, joined[jnp.argmax(x[:10]) + jnp.arange(15)], jnp.diff(x)

    assert agrees(moved, LONG)
