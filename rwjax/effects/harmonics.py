"""What repeats with an angle."""

import jax.numpy as jnp

from rwjax.types import Scalar


def two_harmonics(angle: Scalar, s_1: Scalar, c_1: Scalar, s_2: Scalar, c_2: Scalar) -> Scalar:
    r"""$s_1\sin\alpha + c_1\cos\alpha + s_2\sin 2\alpha + c_2\cos 2\alpha$, from one sine and one cosine."""
    s, c = jnp.sin(angle), jnp.cos(angle)
    return s_1 * s + c_1 * c + s_2 * 2.0 * s * c + c_2 * (c * c - s * s)
