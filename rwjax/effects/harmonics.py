"""What repeats with an angle."""

import jax.numpy as jnp

from rwjax.types import Scalar


def two_harmonics(angle: Scalar, s_1: Scalar, c_1: Scalar, s_2: Scalar, c_2: Scalar) -> Scalar:
    r"""$s_1\sin\alpha + c_1\cos\alpha + s_2\sin 2\alpha + c_2\cos 2\alpha$, from one sine and one cosine."""
    s, c = jnp.sin(angle), jnp.cos(angle)
    return s_1 * s + c_1 * c + s_2 * 2.0 * s * c + c_2 * (c * c - s * s)


def with_overtone(angle: Scalar, s: Scalar, c: Scalar, p: Scalar, q: Scalar) -> Scalar:
    r"""$s\sin\alpha + c\cos\alpha + (p s - q c)\sin 2\alpha + (p c + q s)\cos 2\alpha$: an overtone with $p$ and $q$ of the first one's size,
    so that half the rate with an overtone alone is not the same thing."""
    return two_harmonics(angle, s, c, p * s - q * c, p * c + q * s)
