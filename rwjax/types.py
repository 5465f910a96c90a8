"""Array aliases used in signatures (float64 throughout)."""

from jaxtyping import Array, Float

Scalar = Float[Array, ""]
"""One number; under `jax.vmap` any batch of them."""
