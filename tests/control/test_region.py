"""Gain regions: against roots of the same polynomials, the thesis's counts, the D-partition and the limit of fast sampling."""

import numpy as np
import pytest

from rwjax.control.controller import LoopTiming
from rwjax.control.criteria import ContinuousPoles, SampledPoles
from rwjax.control.loop_polynomial import pd_loop
from rwjax.control.region import region
from rwjax.errors import InputError
from tests.control.thesis_axis import GRID, THESIS
from tests.joints import as_platform, joint


def test_the_region_of_the_thesis() -> None:
    found = region(THESIS, GRID, GRID, 0.5)
    assert found.stable.sum() == 7001
    loop = pd_loop(found.plant)
    by_roots = [[np.all(loop.poles(kp, kd).real < -0.5) for kd in GRID[::5]] for kp in GRID[::5]]
    assert np.array_equal(found.stable[::5, ::5], by_roots)


def test_a_region_prints_itself() -> None:
    found = region(THESIS, GRID, GRID, 0.5)
    assert str(found).splitlines() == [
        "PD gains kp 0 to 100 V/rad, kd 0 to 100 V s/rad:",
        "  7001 of 10201 pairs (68.6 %) put every pole left of -0.5 1/s",
        "  left out: the conserved momentum's pole at 0, which no gain moves",
    ]
    sampled = region(THESIS, GRID[::10], GRID[::10], timing=LoopTiming(0.01))
    assert "put every pole of the loop sampled every 0.01 s within |z| = exp(-0.5 h)" in str(sampled)
    damped = region(THESIS, GRID[::10], GRID[::10], damping=0.4)
    assert str(damped).splitlines()[1].endswith("left of -0.5 1/s, with a damping ratio of 0.4 or more")
    assert (found.period, sampled.period, damped.damping, sampled.damping) == (0.0, 0.01, 0.4, 0.0)


def test_a_region_is_that_of_its_criterion() -> None:
    few, timing = GRID[::10], LoopTiming(0.01, delay_steps=1.0)
    found = region(THESIS, few, few, 1.0, timing=timing, filter_time=0.03, angle=0.2)
    assert np.array_equal(found.stable, SampledPoles(1.0, timing, 0.03, 0.2).holds(THESIS, few, few))
    damped = region(THESIS, few, few, 1.0, damping=0.3, angle=0.2)
    assert np.array_equal(damped.stable, ContinuousPoles(1.0, 0.3, 0.2).holds(THESIS, few, few))


def test_a_damping_ratio_that_cannot_be_asked_for_is_refused() -> None:
    with pytest.raises(InputError, match="damping 1: has to lie between 0 and below 1"):
        region(THESIS, GRID, GRID, damping=1.0)
    with pytest.raises(InputError, match=r"damping 0\.3: is of the continuous loop"):
        region(THESIS, GRID, GRID, damping=0.3, timing=LoopTiming())


def test_the_region_of_a_joint_is_that_of_the_equal_platform() -> None:
    """1 V holds 1 N m. Upside down, 0.02 s² + 2.02 s + K_p - 0.9 has its roots left of -0.5 1/s from K_p = 1.905 on."""
    rig = joint(axis__gravity__torque=-0.9)
    gains = np.array([0.0, 0.9, 1.89, 1.92, 4.0])
    found, same = (region(r, gains, np.array([0.0, 0.2]), 0.5) for r in (rig, as_platform(rig)))
    assert np.array_equal(found.stable, same.stable)
    assert np.array_equal(found.stable[:, 0], gains > 0.9 + 0.5 * 2.02 - 0.25 * 0.02)
