"""The curves of the D-partition are where stability ends."""

import numpy as np
import pytest

from rwjax.control.boundary import boundary, real_boundary
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import pd_loop
from rwjax.control.stability import stable
from rwjax.control.transfer import transfer
from tests.control.thesis_axis import THESIS
from tests.systems import platform, reaction


@pytest.mark.parametrize("sigma", [0.0, 0.5])
@pytest.mark.parametrize("rig", [THESIS, platform(), reaction()], ids=["thesis", "platform", "reaction"])
def test_the_region_ends_on_the_curves_of_the_d_partition(rig, sigma: float) -> None:
    plant = transfer(linearised(rig))
    loop, omega = pd_loop(plant), np.geomspace(0.1, 20.0, 30)
    beside, flips = np.array([1.0 - 1e-9, 1.0 + 1e-9]), 0

    def others_hold(kp: float, kd: float, crossing: complex) -> bool:
        poles = loop.poles(kp, kd)
        assert np.min(np.abs(poles - crossing)) < 1e-8 * max(1.0, abs(crossing))
        for gone in {crossing, crossing.conjugate()}:
            poles = np.delete(poles, np.argmin(np.abs(poles - gone)))
        return bool(np.all(poles.real < -sigma - 1e-3))

    for w, (kp, kd) in zip(omega, boundary(plant, omega, sigma).T, strict=True):
        inside = stable(loop, np.full(2, kp), kd * beside, sigma=sigma)
        if others_hold(kp, kd, complex(-sigma, w)):
            assert inside[0] != inside[1], (kp, kd)
            flips += 1
        else:
            assert not inside.any()
    for kd in np.linspace(0.0, 30.0, 11):
        kp = float(real_boundary(plant, np.array([kd]), sigma)[0])
        beside_kp = kp * beside if abs(kp) > 1e-6 else kp + np.array([-1e-9, 1e-9])
        inside = stable(loop, beside_kp, np.full(2, kd), sigma=sigma)
        if others_hold(kp, kd, complex(-sigma, 0.0)):
            assert inside[0] != inside[1], (kp, kd)
            flips += 1
        else:
            assert not inside.any()
    assert flips > 10
