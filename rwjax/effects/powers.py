"""Powers with any exponent, and what falls along a way at a rate that is a power of itself."""

import jax.numpy as jnp

from rwjax.types import Scalar

STRAIGHT = 1e-3
"""Exponent below which a power is as good as the exponential that it tends to."""


def power(base: Scalar, exponent: Scalar | float) -> Scalar:
    r"""Power $x^p$ of a base above 0.

    With an exponent that is estimated it is $e^{p \ln x}$, exact to $|p \ln x|$ roundings: XLA computes its own power for
    one run of a batch after the other, exponential and logarithm for several at once.

    Args:
        base: The base, above 0 [1].
        exponent: The exponent [1]; a Python number where it is fixed.

    Returns:
        The power [1].
    """
    return base**exponent if isinstance(exponent, float) else jnp.exp(exponent * jnp.log(base))


def fallen(y: Scalar | float, x: Scalar, s: Scalar) -> Scalar:
    r"""What is left of a quantity that falls along a way at the rate $y^{1 - s}$: $(y^s - s x)^{1/s}$.

    For $s \to 0$ it is $y\,e^{-x}$, for $s = 1$ a straight line to 0.

    Args:
        y: The quantity before, 0 or above [1].
        x: The way [1].
        s: The exponent, 0 to 1 [1].

    Returns:
        The quantity after the way, not below 0 [1].
    """
    straight = s > STRAIGHT
    s, known = jnp.where(straight, s, 1.0), jnp.maximum(y, 1e-9)
    return jnp.where(straight, power(jnp.maximum(power(known, s) - s * x, 1e-9), 1.0 / s), y * jnp.exp(-x))
