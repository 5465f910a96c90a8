"""Functions that hand JAX their whole Jacobian: value and derivatives of both modes, worked out once."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from rwjax.simulation.forward_mode import with_jacobian

X = jnp.asarray([0.3, -1.2, 2.0])


def plain(x: Array) -> Array:
    return jnp.sin(jnp.outer(x, x)[:2] * jnp.arange(1.0, 4.0)[None])


def looped(x: Array) -> Array:
    """`plain` through a loop that knows forward mode alone."""
    return jax.lax.while_loop(lambda c: c[0] < 1, lambda c: (c[0] + 1, plain(x)), (0, jnp.zeros((2, 3))))[1]


def test_value_and_derivatives_by_both_modes_are_those_of_the_function() -> None:
    wrapped, dx = with_jacobian(looped), jnp.asarray([1.0, 0.5, -0.2])
    y, forward = jax.jvp(wrapped, (X,), (dx,))
    np.testing.assert_array_equal(y, plain(X))
    np.testing.assert_allclose(forward, jax.jvp(plain, (X,), (dx,))[1], rtol=1e-13)
    weights = jnp.asarray([[1.0, -2.0, 0.5], [0.1, 3.0, -1.0]])
    reverse = jax.vjp(wrapped, X)[1](weights)[0]
    np.testing.assert_allclose(reverse, jax.vjp(plain, X)[1](weights)[0], rtol=1e-13)
    np.testing.assert_allclose(jax.jacrev(wrapped)(X), jax.jacfwd(plain)(X), rtol=1e-13, atol=1e-15)
    with pytest.raises(ValueError, match="Reverse-mode"):
        jax.jacrev(looped)(X)


def test_the_function_runs_once_for_its_value_and_once_for_all_derivatives() -> None:
    ran = []

    def counted(x: Array) -> Array:
        jax.debug.callback(lambda: ran.append(1))
        return plain(x)

    wrapped = with_jacobian(counted)
    wrapped(X)
    jax.effects_barrier()
    assert len(ran) == 1
    _, back = jax.vjp(wrapped, X)
    for k in range(5):  # as an iterative solver would apply it
        back(jnp.full((2, 3), float(k)))
    jax.effects_barrier()
    assert len(ran) == 2, len(ran)
