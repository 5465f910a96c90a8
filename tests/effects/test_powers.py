"""Powers with any exponent."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects.powers import power


@pytest.mark.parametrize("exponent", [-1.5, 0.0, 0.7, 2.0])
def test_a_fixed_and_a_searched_exponent_give_the_same(exponent: float) -> None:
    for base in (1e-6, 0.3, 1.0, 40.0):
        fixed, searched = power(jnp.asarray(base), exponent), power(jnp.asarray(base), jnp.asarray(exponent))
        assert float(searched) == pytest.approx(float(fixed), rel=1e-14)  # |p ln x| roundings: at most 28 of 2e-16
        assert float(fixed) == pytest.approx(base**exponent, rel=1e-15)


def test_its_derivative_by_the_exponent_is_that_of_a_power() -> None:
    slope = jax.grad(lambda p: power(jnp.asarray(0.3), p))(jnp.asarray(1.7))
    assert float(slope) == pytest.approx(np.log(0.3) * 0.3**1.7, rel=1e-14)
