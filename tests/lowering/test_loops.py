"""Loops, sums and products against JAX, in lanes and alone."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.lowering.lowered import agrees

X = np.random.default_rng(4).normal(size=(10, 30))


def _loop(x):
    def turn(carry, v):
        a, b = carry
        return (0.9 * a + v, jnp.where(v > 0.0, b + a, b)), (a, jnp.stack([b, v]))

    return jax.lax.scan(turn, (x[0], jnp.zeros(())), x)


def _loop_within_a_loop(x):
    def inner(c, v):
        return c * 0.5 + v, c

    return jax.lax.scan(lambda c, row: jax.lax.scan(inner, c, row), x[0], x.reshape(6, 5))


def _until(x):
    return jax.lax.while_loop(lambda c: c[1] < 3.0, lambda c: (c[0] + 1, c[1] + jnp.abs(x[0]) + 0.1), (0, 0.0))


def _rows_written(x):
    def turn(given):
        k, y = given
        return k + 1, jax.lax.dynamic_update_index_in_dim(y, x[:4] * k.astype(float), k, 0)

    return jax.lax.while_loop(lambda given: given[0] < 25, turn, (jnp.asarray(0), jnp.zeros((25, 4))))[1]


def _a_line_of_twenty_in_a_scan(x):
    return jax.lax.scan(lambda line, v: (jnp.append(line[1:], 0.5 * line[0] + v), line[3]), x[:20], x)


def _a_line_of_twenty_until(x):
    def turn(given):
        k, line = given
        return k + 1, jnp.append(line[1:], 0.5 * line[0] + k.astype(float))

    return jax.lax.while_loop(lambda given: given[0] < 33, turn, (jnp.asarray(0), x[:20]))[1]


CASES = {
    "loop": _loop,
    "loop within a loop": _loop_within_a_loop,
    "no turn at all": lambda x: jax.lax.scan(lambda c, v: (c * v, c + v), jnp.sin(x[:3]), x[:0]),
    "until": _until,
    "rows written": _rows_written,
    "a line of twenty in a scan": _a_line_of_twenty_in_a_scan,
    "a line of twenty until": _a_line_of_twenty_until,
    "sums": lambda x: (jnp.sum(x), jnp.min(x), jnp.max(x), jnp.sum(x.reshape(3, 10), axis=0), jnp.any(x > 2.0)),
    "running": lambda x: (jnp.cumsum(x), jnp.cumsum(jnp.abs(x))[-1]),
    "products": lambda x: (x[:9].reshape(3, 3) @ x[9:12], x[:9].reshape(3, 3) @ x[9:18].reshape(3, 3), x[:4] @ x[4:8]),
}


@pytest.mark.parametrize("name", CASES)
def test_arrays_are_those_of_jax(name: str) -> None:
    assert agrees(CASES[name], X)
