"""Array aliases used in signatures (float64 throughout), and a vector's entries as such scalars."""

import jax
from jaxtyping import Array, Float

Scalar = Float[Array, ""]
"""One number; under `jax.vmap` any batch of them."""


def entries(vector: Float[Array, " n"]) -> tuple[Scalar, ...]:
    """The entries of a vector: to trace one split takes a fraction of what as many look-ups do.

    Args:
        vector: The vector `(n,)` [any unit].

    Returns:
        Its entries, each `()` [the same unit].
    """
    return tuple(jax.lax.squeeze(part, (0,)) for part in jax.lax.split(vector, (1,) * len(vector)))
