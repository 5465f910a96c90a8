"""Primitives of single numbers against JAX, in lanes and alone."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.extend.core import Primitive
from jax.interpreters import mlir

from rwjax.lowering.arrays import Spread
from rwjax.lowering.elementwise import is_elementwise
from rwjax.lowering.program import Lowered, build
from tests.lowering.lowered import agrees

X = np.random.default_rng(1).normal(size=(11, 2)) * 3.0
CASES = {
    "arithmetic": lambda x: (x[0] + x[1], x[0] - x[1], x[0] * x[1], x[0] / x[1], -x[0], x[0] / 7.0),
    "compared": lambda x: (x[0] < x[1], x[0] <= x[1], x[0] > x[1], x[0] >= x[1], x[0] == x[1], x[0] != x[1]),
    "truth": lambda x: (~(x[0] > 0.0), (x[0] > 0.0) & (x[1] > 0.0), (x[0] > 0.0) | (x[1] > 0.0)),
    "rounded": lambda x: (jnp.floor(x[0]), jnp.ceil(x[0]), jnp.round(x[0]), jax.lax.round(x[0]), jnp.trunc(x[0])),
    "powers": lambda x: (
        x[0] ** 2,
        x[0] ** 3,
        x[0] ** -3,
        jnp.abs(x[0]) ** x[1],
        jnp.sqrt(jnp.abs(x[0])),
        jnp.square(x[1]),
    ),
    "roots": lambda x: (jax.lax.rsqrt(jnp.abs(x[0])), jnp.sign(x[0]), jnp.abs(x[1])),
    "between": lambda x: (jnp.clip(x[0], -1.0, x[1]), jnp.maximum(x[0], x[1]), jnp.minimum(x[0], 0.0)),
    "converted": lambda x: (
        x[0].astype(int) + 2,
        (x[0] > x[1]).astype(float),
        x[0].astype(int).astype(float),
        x[0].astype(bool),
    ),
    "whole": lambda x: (x[0].astype(int) // 3, jnp.maximum(x[0].astype(int), 1), jnp.sign(x[0].astype(int))),
    "finite": lambda x: (jnp.isfinite(x[0] / 0.0), jnp.isfinite(x[0])),
}


@pytest.mark.parametrize("name", CASES)
def test_a_number_is_that_of_jax(name: str) -> None:
    assert agrees(CASES[name], X)


def test_one_less_a_square_as_newer_versions_of_jax_have_it_in_slopes() -> None:
    newer = Primitive("one_minus_square")
    newer.def_abstract_eval(lambda x: x)
    mlir.register_lowering(newer, mlir.lower_fun(lambda x: 1.0 - x * x, multiple_results=False))
    jax.interpreters.batching.defvectorized(newer)
    assert agrees(jax.jit(newer.bind), X[:, 0])
    near = 1.0 - np.array([[2.0**-40], [2.0**-45]])
    (found,) = Lowered(build(newer.bind, [near[0]], [Spread(lanes=True)], 8))([near], rows=2)
    assert np.allclose(found, (1.0 - near) * (1.0 + near), rtol=1e-15, atol=0.0)


def test_division_by_what_stays_the_same_in_a_loop_is_a_product_within_a_rounding() -> None:
    def divided(x):
        return jax.lax.scan(lambda c, k: (c / x[1] + k / 3.0, c / x[1]), x[0], jnp.arange(5.0))[1]

    assert agrees(divided, np.abs(X) + 0.5, within=1e-14)


def test_what_is_not_known_is_said() -> None:
    assert is_elementwise("sin") and not is_elementwise("sort")
