"""Values and derivatives of a function as machine code, against closed forms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from rwjax.lowering.slopes import with_slopes


def decay(z: Array, step: Array) -> tuple[Array, Array]:
    """A decay z₁ exp(−z₀ t) step by step, and a number that only z₁ changes."""
    x, seen = jax.lax.scan(lambda x, _: (x * jnp.exp(-z[0] * step), x), z[1], length=20)
    return jnp.append(seen, x), 3.0 * z[1] ** 2


@pytest.mark.parametrize("more", [0, 9])  # fewer unknowns than a vector has lanes, and more
def test_a_decay_and_its_slopes_are_those_on_paper(more: int) -> None:
    z, h = np.append([0.7, 2.0], np.ones(more)), 0.05
    found = with_slopes("decay", None, decay, z, [np.array(h)], keep=False)
    assert found is not None
    (x, square), (by_x, by_square) = found
    t = h * np.arange(21)
    exact = 2.0 * np.exp(-0.7 * t)
    np.testing.assert_allclose(x, exact, rtol=1e-12)
    np.testing.assert_allclose(by_x[:, :2], np.stack([-t * exact, exact / 2.0], axis=1), rtol=1e-12, atol=1e-14)
    assert square == pytest.approx(12.0, rel=1e-14) and by_square[:2] == pytest.approx([0.0, 12.0], rel=1e-14)
    assert not by_x[:, 2:].any() and not by_square[2:].any()
    assert by_x.shape == (21, len(z)) and by_square.shape == (len(z),)


def test_what_no_unknown_changes_has_no_slope_beside_a_loop_that_has_one() -> None:
    def both(z: Array, other: Array) -> tuple[Array, Array]:
        x, y = jax.lax.scan(lambda c, _: ((c[0] * z[0], c[1] * other), c[1]), (z[0], other), length=5)[0]
        return x, y + 1.0

    found = with_slopes("both", None, both, np.array([2.0]), [np.array(3.0)], keep=False)
    assert found is not None
    assert [v.item() for v in found[0]] == [2.0**6, 3.0**6 + 1.0]
    assert [v.item() for v in found[1]] == [6 * 2.0**5, 0.0]
