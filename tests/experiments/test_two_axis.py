"""The plant with two axes against the same bodies in MuJoCo."""

import os

import numpy as np
import pytest

if os.environ.get("RWJAX_FIRMWARE") != "required":  # where the continuous test sets it, nothing may be missing
    pytest.importorskip("mujoco", reason="the independent rigid bodies need the extra `rigid`")

from experiments.two_axis.rigid import lopsided, simulate
from tests.two_axes import motion


@pytest.mark.parametrize("tilts", [True, False])
def test_the_motion_is_that_of_rigid_bodies_in_mujoco(tilts: bool) -> None:
    bed = lopsided(tilts)
    t = 0.02 * np.arange(200)
    u = np.stack([6.0 * np.sign(np.sin(1.7 * t)), 3.0 * np.cos(2.3 * t)], axis=1)
    start = {"w_1": 1.0, "psi_2": 0.4, "Omega_1": 250.0, "Omega_2": -60.0}
    exact = simulate(bed, start, u, 0.02, 1e-3)
    error = []
    for k in (8, 16):
        found = motion(bed.rig(), start, u, 0.02 / k, k)
        error.append([np.max(np.abs(found[name] - exact[name])) / np.ptp(exact[name]) for name in exact])
    assert np.ptp(exact["psi_2"]) > 0.5 and np.ptp(exact["psi_1"]) > 1.0
    assert np.max(error[1]) < 1e-4  # of the range; the step's own error is a tenth of it
    assert np.all(np.log2(np.array(error[0]) / np.array(error[1])) > 1.8), (
        error
    )  # only the step's own second order is left
