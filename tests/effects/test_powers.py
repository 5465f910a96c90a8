"""Powers with any exponent."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects.powers import fallen, power


@pytest.mark.parametrize("exponent", [-1.5, 0.0, 0.7, 2.0])
def test_a_fixed_and_a_searched_exponent_give_the_same(exponent: float) -> None:
    for base in (1e-6, 0.3, 1.0, 40.0):
        fixed, searched = power(jnp.asarray(base), exponent), power(jnp.asarray(base), jnp.asarray(exponent))
        assert float(searched) == pytest.approx(float(fixed), rel=1e-14)  # |p ln x| roundings: at most 28 of 2e-16
        assert float(fixed) == pytest.approx(base**exponent, rel=1e-15)


def test_its_derivative_by_the_exponent_is_that_of_a_power() -> None:
    slope = jax.grad(lambda p: power(jnp.asarray(0.3), p))(jnp.asarray(1.7))
    assert float(slope) == pytest.approx(np.log(0.3) * 0.3**1.7, rel=1e-14)


@pytest.mark.parametrize("s", [0.0, 0.3, 0.5, 1.0])
def test_what_falls_at_a_power_of_itself(s: float) -> None:
    """Against small steps of dy/dx = -y^(1 - s)."""
    y, way, steps = 0.9, 0.6, 20_000
    for _ in range(steps):
        middle = y - 0.5 * way / steps * y ** (1.0 - s)
        y -= way / steps * middle ** (1.0 - s)
    assert float(fallen(jnp.asarray(0.9), jnp.asarray(way), jnp.asarray(s))) == pytest.approx(y, rel=1e-8)


def test_what_has_fallen_to_its_end_stays_there() -> None:
    assert float(fallen(jnp.asarray(0.5), jnp.asarray(3.0), jnp.asarray(1.0))) == pytest.approx(0.0, abs=1e-8)
