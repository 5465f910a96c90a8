"""Rings by integration, and the slew of the thesis."""

import numpy as np
import pytest
from scipy.integrate import dblquad

from rwjax.control.ring import Ring, slew_time
from tests.control.sized_rig import TOP


def test_a_ring_weighs_and_turns_as_its_integrals_say() -> None:
    ring = Ring(0.05, 0.04, 0.005)
    mass, inertia = (dblquad(lambda r, _, p=p: 2700.0 * 0.005 * r**p, 0.0, 2.0 * np.pi, 0.04, 0.05)[0] for p in (1, 3))
    assert ring.mass == pytest.approx(mass) and ring.inertia == pytest.approx(inertia)
    assert ring.inertia / ring.thin_inertia == pytest.approx(0.82)  # thesis eq. 2.7 has 18 % too much


def test_the_thesis_s_slew_of_90_degrees_in_15_seconds() -> None:
    momentum = Ring(0.05, 0.04, 0.005).thin_inertia * TOP
    assert slew_time(0.19, 0.5 * np.pi, momentum) == pytest.approx(15.0, rel=0.01)
