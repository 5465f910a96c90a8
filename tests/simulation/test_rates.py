"""Rates along a given motion."""

import numpy as np

from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.rates import rates_along
from tests.systems import platform


def test_a_platform_slides_or_is_held_as_its_equation_says() -> None:
    I, b, M_c, k = 0.1, 0.02, 0.05, 0.4
    structure = structure_of(platform())
    w, u = np.array([2.0, -2.0, 0.0, 0.0, 0.0]), np.array([0.5, 0.5, 0.1, 0.5, -0.5])
    states = np.stack([np.arange(5.0), w], axis=1)
    found = np.asarray(rates_along(structure, theta_of(platform(), structure), np.zeros(5), states, u))
    friction = np.where(w != 0.0, np.sign(w) * M_c, np.clip(k * u, -M_c, M_c))
    assert np.array_equal(found[:, 0], w)
    assert np.allclose(found[:, 1], (k * u - b * w - friction) / I, rtol=1e-12, atol=1e-15)
    assert found[2, 1] == 0.0  # held exactly
