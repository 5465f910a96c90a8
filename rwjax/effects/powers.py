"""Powers with any exponent."""

import jax.numpy as jnp

from rwjax.types import Scalar


def power(base: Scalar, exponent: Scalar | float) -> Scalar:
    r"""Power $x^p$ of a base above 0.

    With an exponent that is estimated it is $e^{p \ln x}$, exact to $|p \ln x|$ roundings: XLA computes its own power for
    one run of a batch after the other, exponential and logarithm for several at once.

    Args:
        base: The base, above 0.
        exponent: The exponent [1]; a Python number where it is fixed.

    Returns:
        The power.
    """
    return base**exponent if isinstance(exponent, float) else jnp.exp(exponent * jnp.log(base))
