"""A controller on many plants, against its loop by its own z transform."""

import numpy as np
import pytest

from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.robustness import robustness
from rwjax.plant.from_rig import structure_of, theta_of
from tests.control.tuned_platform import RIG, TIMING


def test_a_controller_is_judged_on_every_plant_with_its_integral() -> None:
    thetas = np.tile(theta_of(RIG, structure_of(RIG)), (4, 1))
    thetas[:, structure_of(RIG).names.index("drive.gain")] *= [1.0, 2.0, 30.0, 60.0]
    law = Controller(10.0, ki=2.0, kd=2.5, filter_time=0.02)
    assert robustness(RIG, thetas, TIMING, law) == (0.5, 0.0)
    assert robustness(RIG, thetas, LoopTiming(1e-4), law._replace(filter_time=0.0)).stable == 1.0
    # the loop of 0.4/(0.1 s^2 + 0.02 s), held 10 ms, by its own z transform
    h, a = 0.01, 0.2
    z = np.exp(1j * np.geomspace(1e-3, np.pi, 20_000))
    lag = np.exp(-a * h)
    for ki in (0.0, 2.0, 20.0):
        worst = []
        for gain in (4.0, 8.0):
            plant = gain / a**2 * ((a * h - 1.0 + lag) * z + 1.0 - lag - a * h * lag) / ((z - 1.0) * (z - lag))
            slope = (z - 1.0) / ((0.02 + h) * z - 0.02)
            worst.append(np.min(np.abs(1.0 + plant * (10.0 + ki * h / (z - 1.0) + 2.5 * slope))))
        assert robustness(RIG, thetas[:2], TIMING, law._replace(ki=ki)).modulus == pytest.approx(min(worst), rel=1e-4)
