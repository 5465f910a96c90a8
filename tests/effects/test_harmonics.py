"""What repeats with an angle, against sines and cosines written out."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects.harmonics import two_harmonics, with_overtone

ANGLES = np.linspace(-7.0, 7.0, 23)


def over(function: Callable, *numbers: float) -> np.ndarray:
    """A function of an angle and numbers at `ANGLES`."""
    return np.asarray(jax.vmap(lambda angle: function(angle, *map(jnp.asarray, numbers)))(jnp.asarray(ANGLES)))


def test_two_harmonics_are_sines_and_cosines_of_one_and_two_angles() -> None:
    found = over(two_harmonics, 0.3, -0.7, 0.2, 1.1)
    exact = 0.3 * np.sin(ANGLES) - 0.7 * np.cos(ANGLES) + 0.2 * np.sin(2 * ANGLES) + 1.1 * np.cos(2 * ANGLES)
    assert np.max(np.abs(found - exact)) < 1e-14


def test_the_overtone_has_the_amplitude_of_the_first_one_times_p_and_q() -> None:
    s, c, p, q = 0.4, -0.9, 0.5, 0.25
    found = over(with_overtone, s, c, p, q)
    first = (c - 1j * s) * np.exp(1j * ANGLES)
    second = (p + 1j * q) * (c - 1j * s) * np.exp(2j * ANGLES)
    assert np.max(np.abs(found - np.real(first + second))) < 1e-14


@pytest.mark.parametrize("shift", [0.0, 1.3])
def test_without_a_first_harmonic_there_is_no_overtone(shift: float) -> None:
    whole = over(with_overtone, 0.0, 0.0, 1.0, shift)
    assert np.all(whole == 0.0)
