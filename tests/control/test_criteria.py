"""Criteria for poles: sampled and continuous, against the poles themselves."""

import numpy as np
import pytest

from rwjax.control.criteria import ContinuousPoles, SampledPoles
from rwjax.control.linear import linearised
from rwjax.control.margins import pd_margins, sampled_modulus
from rwjax.control.region import region, region_of
from rwjax.control.sampled_loop import SampledLaw, sampled_loops
from rwjax.control.stability import share_of_plants
from rwjax.control.transfer import transfer
from rwjax.plant.from_rig import structure_of, theta_of
from tests.control.delayed_platform import GAIN, INERTIA, RIG, SMOOTH, TIMING, VISCOUS, with_delays

GRID, RATES = np.linspace(0.0, 60.0, 13), np.linspace(0.0, 12.0, 13)


@pytest.mark.slow
def test_a_sampled_region_holds_the_rig_s_delay_and_its_margins() -> None:
    asked = SampledPoles(1.0, TIMING, SMOOTH)
    late = with_delays(0.02, 0.0)
    found, without = (region_of(rig, asked, GRID, GRID) for rig in (late, RIG))
    assert 5 < found.stable.sum() < without.stable.sum() - 5
    (loop,) = sampled_loops(late, SampledLaw(TIMING, SMOOTH))
    margins = found.margins()["modulus"]
    for (i, kp), (j, kd) in ((a, b) for a in enumerate(GRID) for b in enumerate(GRID)):
        size = np.max(np.abs(1.0 + loop.poles(kp, kd)))
        assert found.stable[i, j] == (size < np.exp(-0.01)) and np.isnan(margins[i, j]) == (not found.stable[i, j])
        if found.stable[i, j]:
            assert margins[i, j] == pytest.approx(sampled_modulus(loop, kp, kd))
    thetas = theta_of(late, structure_of(late))[None]
    assert np.array_equal(found.share_of_plants(thetas) == 1.0, found.stable)


def test_without_a_derivative_its_filter_is_none_of_the_loop() -> None:
    kp, kd, rig = np.array([0.05, 0.1]), np.array([0.0, 0.05]), RIG.with_values({"axis.friction.viscous": 0.1})
    slow, fast = SampledPoles(0.25, TIMING, 5.0), SampledPoles(0.25, TIMING, 0.0)
    found, thetas = region_of(rig, slow, kp, kd), theta_of(rig, structure_of(rig))[None]
    assert np.array_equal(found.stable[:, 0], region_of(rig, fast, kp, kd).stable[:, 0]) and found.stable[1, 0]
    assert np.array_equal(found.share_of_plants(thetas) == 1.0, found.stable)


def test_a_damped_region_and_its_margins() -> None:
    plain, damped = (region_of(RIG, ContinuousPoles(0.5, damping), GRID, RATES) for damping in (0.0, 0.7))
    plant = transfer(linearised(RIG))
    ratio = np.array([[_damping(kp, kd) for kd in RATES] for kp in GRID])
    clear = np.abs(ratio - 0.7) > 1e-9
    assert np.array_equal(damped.stable[clear], (plain.stable & (ratio > 0.7))[clear])
    assert 5 < damped.stable.sum() < plain.stable.sum() - 5
    assert np.array_equal(region(RIG, GRID, RATES, 0.5).stable, plain.stable)
    i, j = np.argwhere(damped.stable)[3]
    margins, own = damped.margins(), pd_margins(plant, GRID[i], RATES[j])
    assert [float(margins[name][i, j]) for name in margins] == [*own.gain, own.phase, own.delay, own.modulus]
    thetas = np.tile(theta_of(RIG, structure_of(RIG)), (3, 1))
    thetas[:, structure_of(RIG).names.index("axis.inertia")] *= [0.5, 1.0, 2.0]
    plants = transfer(linearised(RIG, thetas=thetas))
    share = share_of_plants(plants, GRID, RATES, 0.5, 0.7)
    others = [
        region_of(RIG.with_values({"axis.inertia": f * INERTIA}), ContinuousPoles(0.5, 0.7), GRID, RATES)
        for f in (0.5, 1.0, 2.0)
    ]
    assert np.array_equal(share, np.mean([one.stable.astype(float) for one in others], axis=0))


def test_the_slowest_pole_of_every_pair() -> None:
    kp, kd = GRID[:4], RATES[:3]
    found = region_of(RIG, ContinuousPoles(0.5), kp, kd).slowest()
    roots = [[np.roots([INERTIA, VISCOUS + GAIN * d, GAIN * p]) for d in kd] for p in kp]
    assert found == pytest.approx(np.max(np.real(roots), axis=-1), abs=1e-9)
    sampled = region_of(RIG, SampledPoles(0.5, TIMING, 2.0), kp, kd)  # a filter slower than the loop
    filtered, plain = (sampled_loops(RIG, SampledLaw(TIMING, smooth))[0] for smooth in (2.0, 0.0))
    rates = [
        [np.log(np.max(np.abs(1.0 + (filtered if d else plain).poles(p, d)))) / TIMING.period for d in kd] for p in kp
    ]
    assert sampled.slowest() == pytest.approx(np.array(rates), abs=1e-6)
    assert np.array_equal(sampled.slowest() < -0.5, sampled.stable) and found[2, 0] < 0.0 < sampled.slowest()[2, 0]


def _damping(kp: float, kd: float) -> float:
    """Least damping ratio of I s² + (b + k K_d) s + k K_p."""
    poles = np.roots([INERTIA, VISCOUS + GAIN * kd, GAIN * kp])
    return float(np.min(-poles.real / np.maximum(np.abs(poles), 1e-300)))
