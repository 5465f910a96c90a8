"""Choices against JAX: where all lanes take one side, where they differ, with derivatives, and around and inside loops."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from rwjax.lowering.arrays import Spread
from rwjax.lowering.emitter import Unsupported
from rwjax.lowering.program import Lowered, assembled, build
from tests.lowering.lowered import LANES, agrees

RNG = np.random.default_rng(5)
MIXED = RNG.normal(size=(20, 6))
"""Rows some of whose first numbers are above 0."""


def _one_sided(x: Array) -> Array:
    return jax.lax.cond(x[0] > 0.0, lambda: jnp.sqrt(x[0]) / x[1], lambda: x[2])


def _two_sided(x: Array) -> tuple[Array, Array, Array]:
    return jax.lax.cond(
        x[0] > x[1], lambda: (jnp.exp(x[2]), x[:2], x[0] > 1.0), lambda: (x[3] / x[4], x[2:4], x[5] > 0.0)
    )


def _within_a_loop(x: Array) -> tuple[Array, Array]:
    """A ball that bounces off the ground: its fall is divided by what stays the same, inside the choice and outside it."""

    def step(c: tuple[Array, Array], k: Array) -> tuple[tuple[Array, Array], Array]:
        y, v = c[0] + 0.1 * c[1] / x[5], c[1] - 0.1 / x[4]
        y, v = jax.lax.cond(y < 0.0, lambda: (-0.9 * y / x[5], -0.9 * v / x[4]), lambda: (y, v))
        return (y, v / x[5] * x[5]), y * k / x[4]

    return jax.lax.scan(step, (jnp.abs(x[0]), x[1]), jnp.arange(40.0))[1], x[5]


def _around_a_loop(x: Array) -> Array:
    def falls() -> Array:
        return jax.lax.fori_loop(0, 5, lambda _, y: 0.5 * y + x[1] * x[2], x[0])

    return jax.lax.cond(x[0] > 0.0, falls, lambda: x[3]) + x[1] * x[2]


def _nested(x: Array) -> Array:
    inner = lambda: jax.lax.cond(x[1] > 0.0, lambda: jnp.log(x[1]), lambda: x[2] * x[3])  # noqa: E731
    return jax.lax.cond(x[0] > 0.0, inner, lambda: x[4]) * x[3]


CASES = {
    "one side": _one_sided,
    "two sides": _two_sided,
    "within a loop": _within_a_loop,
    "around a loop": _around_a_loop,
    "one in another": _nested,
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("rows", ["mixed", "all", "none"])
def test_each_lane_takes_its_own_side(name: str, rows: str) -> None:
    x = MIXED.copy()
    if rows != "mixed":
        x[:, 0] = 5.0 if rows == "all" else -5.0
    assert agrees(CASES[name], x)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("lanes", [True, False])
def test_derivatives_are_those_of_the_side_that_is_taken(name: str, lanes: bool) -> None:
    def one(x: Array) -> list[Array]:
        return [v for v in jax.tree.leaves(CASES[name](x)) if v.dtype == float]

    def along(x: Array, dx: Array) -> list[Array]:
        values, moved = jax.jvp(one, (x,), (dx,))
        return [*values, *moved]

    directions = np.eye(6)
    code = build(along, [MIXED[0], directions[0]], [Spread(lanes=lanes), Spread(directions=True)], LANES)
    rows = len(MIXED) if lanes else 1
    found = Lowered(code)([MIXED if lanes else MIXED[0], directions], rows=rows, directions=6)
    half = len(found) // 2
    for value, moved, wanted, slope in zip(
        found[:half], found[half:], jax.vmap(one)(MIXED), jax.vmap(jax.jacfwd(one))(MIXED), strict=True
    ):
        wanted, slope = (wanted, slope) if lanes else (wanted[0], slope[0])
        np.testing.assert_allclose(value, wanted, rtol=1e-13, atol=1e-14)
        np.testing.assert_allclose(np.moveaxis(moved, 0, -1), slope, rtol=1e-12, atol=1e-13)


def test_a_side_that_no_lane_takes_is_passed_over() -> None:
    text, _ = assembled(jax.make_jaxpr(_one_sided)(MIXED[0]), [Spread(lanes=True)], LANES)
    root = text.index("sqrt")
    assert text.rindex("branch", 0, root) > text.rindex("br i1", 0, root)  # the root stands behind a jump of its own


def test_a_choice_among_three_says_so() -> None:
    with pytest.raises(Unsupported, match="more than two"):
        agrees(lambda x: jax.lax.switch(jnp.where(x[0] > 0.0, 2, 0), [jnp.sin, jnp.cos, jnp.tan], x[1]), MIXED)
