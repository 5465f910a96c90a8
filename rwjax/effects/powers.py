"""Powers with any exponent."""

import jax.numpy as jnp

from rwjax.types import Scalar


def power(base: Scalar, exponent: Scalar) -> Scalar:
    r"""$x^p = e^{p \ln x}$ of a positive base, to $|p \ln x|$ roundings: XLA calls its own power once for each of many lanes."""
    return jnp.exp(exponent * jnp.log(base))
