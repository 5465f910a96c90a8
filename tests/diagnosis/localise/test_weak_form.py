"""The weak form against derivatives that are known."""

import numpy as np
import pytest

from rwjax.diagnosis.localise.body_motion import read_body
from rwjax.diagnosis.localise.weak_form import WeakForm, bump
from rwjax.diagnosis.settings import LocalisationSettings
from tests.diagnosis.localise.measured import TIME, as_given
from tests.systems import platform, record


def test_test_functions_have_unit_area_and_their_own_derivatives() -> None:
    s = np.linspace(-1.0, 1.0, 20001)
    value, first, second = bump(s, 0.4)
    t = 0.2 * s
    assert np.trapezoid(value, t) == pytest.approx(1.0, abs=1e-6)
    assert np.allclose(np.gradient(value, t)[1:-1], first[1:-1], atol=1e-4 * np.max(first))
    assert np.allclose(np.gradient(first, t)[1:-1], second[1:-1], atol=1e-4 * np.max(second))


@pytest.mark.parametrize("name", ["yaw_rad", "yaw_rad_s"])
def test_a_steady_acceleration_is_found_without_a_derivative(name: str) -> None:
    exact = {"yaw_rad": 0.5 * 0.7 * TIME**2, "yaw_rad_s": 0.7 * TIME}[name]
    noisy = exact + 1e-3 * np.random.default_rng(0).normal(size=len(TIME))
    rig = platform()
    read = read_body(as_given(rig, record(TIME, TIME, {name: noisy})), 0, "yaw", LocalisationSettings())
    assert read is not None
    weak = WeakForm.of(TIME, 2.0)
    error = weak.acceleration(read, slice(0, 1))[:, 0] - 0.7
    assert np.sqrt(np.mean(error**2)) < 2.0 * np.median(weak.noise(read, 1e-3)) < 0.1
