"""What repeats with an angle."""

import jax.numpy as jnp

from rwjax.types import Scalar


def two_harmonics(angle: Scalar, s_1: Scalar, c_1: Scalar, s_2: Scalar, c_2: Scalar) -> Scalar:
    r"""$s_1\sin\alpha + c_1\cos\alpha + s_2\sin 2\alpha + c_2\cos 2\alpha$, from one sine and one cosine.

    Args:
        angle: The angle [rad].
        s_1: Amplitude of the sine [any unit].
        c_1: Amplitude of the cosine [as the sine].
        s_2: Amplitude of the sine of twice the angle [as the sine].
        c_2: Amplitude of the cosine of twice the angle [as the sine].

    Returns:
        The sum [as the amplitudes].
    """
    s, c = jnp.sin(angle), jnp.cos(angle)
    return s_1 * s + c_1 * c + s_2 * 2.0 * s * c + c_2 * (c * c - s * s)


def with_overtone(angle: Scalar, s: Scalar, c: Scalar, p: Scalar, q: Scalar) -> Scalar:
    r"""A harmonic and its overtone, $s\sin\alpha + c\cos\alpha + (p s - q c)\sin 2\alpha + (p c + q s)\cos 2\alpha$.

    The overtone counts in units of the first harmonic. So half the rate with an overtone alone is not the same thing.

    Args:
        angle: The angle [rad].
        s: Amplitude of the sine [any unit].
        c: Amplitude of the cosine [as the sine].
        p: Overtone in phase with the first harmonic, over its size [1].
        q: Overtone a quarter of a turn apart, over its size [1].

    Returns:
        The sum [as the amplitudes].
    """
    return two_harmonics(angle, s, c, p * s - q * c, p * c + q * s)
