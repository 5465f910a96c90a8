"""Powers with any exponent."""

import jax.numpy as jnp

from rwjax.types import Scalar


def power(base: Scalar, exponent: Scalar | float) -> Scalar:
    r"""$x^p$ of a base above 0; with an exponent that is a number to be found, $e^{p \ln x}$ to $|p \ln x|$ roundings: of its own power XLA
    works out one lane after the other, of exponential and logarithm several at once."""
    return base**exponent if isinstance(exponent, float) else jnp.exp(exponent * jnp.log(base))
