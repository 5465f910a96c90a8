"""Gains that hold for all plants that a fit leaves possible, with the largest worst-case margin."""

import numpy as np
import pytest

from rwjax import Rig, parse_rig
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.fit_estimate import draw_plants
from rwjax.control.linear import linearised
from rwjax.control.margins import pd_margins, sampled_modulus
from rwjax.control.robust_gains import robust_gains
from rwjax.control.sampled_loop import sampled_loop
from rwjax.control.stability import share_of_plants
from rwjax.control.transfer import transfer
from rwjax.control.tuning import tune_from
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from tests.control.fit_of_a_rig import ESTIMATE
from tests.systems import platform, reaction

AXIS = np.linspace(0.0, 100.0, 41)


@pytest.mark.slow
def test_gains_that_hold_for_the_plants_drawn_hold_for_fresh_ones() -> None:
    rig, sigma, count = reaction(), 0.5, 300
    drawn, fresh = (
        transfer(linearised(rig, thetas=draw_plants(rig, ESTIMATE, n, seed))) for n, seed in ((count, 1), (5000, 2))
    )
    share, again = share_of_plants(drawn, AXIS, AXIS, sigma), share_of_plants(fresh, AXIS, AXIS, sigma)
    # a pair that holds for all of N plants fails a fresh one with a chance of 1/(N + 1) at most on average; and the shares agree
    assert np.mean(again[share == 1.0]) > 1.0 - 1.0 / (count + 1)
    edge = (share > 0.0) & (share < 1.0)
    assert edge.sum() > 20
    assert np.max(np.abs(share - again)[edge]) < 4.5 * 0.5 / np.sqrt(count)  # 4.5 deviations of a count out of 300


TIMING, SMOOTH = LoopTiming(delay_steps=2.0), 0.02


@pytest.mark.slow
def test_no_other_gains_have_a_larger_worst_case_margin() -> None:
    rig = reaction()
    thetas = draw_plants(rig, ESTIMATE, 60)
    found = robust_gains(rig, thetas, AXIS, AXIS, 2.0, TIMING, SMOOTH)
    each = [sampled_loop(plant, 0.01, 0.005, SMOOTH) for plant in transfer(linearised(rig, thetas=thetas)).each()]

    def slowest(gains: np.ndarray) -> float:
        return max(np.max(np.abs(1.0 + loop.poles(*gains))) for loop in each)

    rng, compared = np.random.default_rng(3), 0
    while compared < 40:
        near = np.array([found.kp, found.kd]) * np.exp(rng.normal(0.0, 0.5 if compared % 2 else 0.05, 2))
        if slowest(near) >= np.exp(-0.02) or near.max() > 100.0:
            continue
        # 2e-3: of the grids of gains and frequencies
        assert min(sampled_modulus(loop, *near) for loop in each) <= found.modulus + 2e-3
        compared += 1
    assert slowest(np.array([found.kp, found.kd])) < np.exp(-0.02)


@pytest.mark.parametrize(
    "rig", [platform(), reaction().with_values({"motor.inductance": 0.0})], ids=["platform", "reaction"]
)
def test_gains_stay_below_what_sampling_bears(rig) -> None:
    # without inductance the loop falls with 1/s at high gains: in continuous time any gain keeps 1 from -1
    found = robust_gains(rig, theta_of(rig, structure_of(rig))[None], AXIS, AXIS, 0.5, TIMING, SMOOTH)
    assert 0.0 < found.kp < 100.0 and 0.0 < found.kd < 100.0
    (plant,) = transfer(linearised(rig, thetas=theta_of(rig, structure_of(rig))[None])).each()
    assert 0.5 < found.modulus < 1.0
    margins = pd_margins(plant, found.kp, found.kd)
    # the delay that the loop has on top: held, differenced, late, filtered
    assert margins.delay > 0.005 + 0.005 + 0.005
    run = run_rig(rig, Controller(found.kp, kd=found.kd, filter_time=SMOOTH), np.full(600, 1e-3), TIMING)
    assert np.all(np.abs(run.angle) < 2e-3)


SPAN = np.array([0.0, 100.0])


def held(inertia: float, friction: str) -> Rig:
    return parse_rig(f'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = {inertia}\n{friction}')


def alone(rig: Rig) -> np.ndarray:
    return theta_of(rig, structure_of(rig))[None]


def test_the_small_gains_of_a_light_strong_rig_are_found() -> None:
    # kp = 0.05, kd = 0.02 damp it, by the roots of its loop; a grid of 31 steps begins at 3.3
    rig = held(0.002, "[axis.friction]\nviscous = 5e-4")
    (plant,) = transfer(linearised(rig, thetas=alone(rig))).each()
    loop, radius = sampled_loop(plant, 0.01, 0.0, SMOOTH), np.exp(-0.5 * 0.01)
    assert np.max(np.abs(1.0 + loop.poles(0.05, 0.02))) < radius < np.max(np.abs(1.0 + loop.poles(3.3, 3.3)))
    found = robust_gains(rig, alone(rig), SPAN, SPAN, 0.5, LoopTiming(), SMOOTH)
    assert np.max(np.abs(1.0 + loop.poles(found.kp, found.kd))) < radius
    assert found.kp > 0.0 and found.modulus >= sampled_modulus(loop, 0.05, 0.02)


def test_a_rig_that_its_own_weight_brings_back_is_tuned_from_a_gain_above_0() -> None:
    # the pendulum's poles lie at -0.25 +- 2.2j, so that damping alone would put them left of -0.5
    rig = held(0.1, "[axis.friction]\nviscous = 0.05\n[axis.gravity]\ntorque = 0.5")
    found = robust_gains(rig, alone(rig), SPAN, SPAN, 0.5, LoopTiming(), SMOOTH)
    assert 0.0 < found.kp < 0.1
    law = Controller(found.kp, kd=found.kd, filter_time=SMOOTH, voltage_limit=10.0)
    tuned = tune_from(rig, law, np.full(300, 0.2), LoopTiming()).controller
    run = run_rig(rig, tuned, np.full(300, 0.2))
    # what stays against the weight: 0.4 kp (0.2 - psi) = 0.5 sin psi
    assert tuned.kp > 10.0 and run.angle[-1] == pytest.approx(0.2 * 0.4 * tuned.kp / (0.4 * tuned.kp + 0.5), rel=2e-3)


def test_gains_beyond_the_ranges_are_told_from_none() -> None:
    with pytest.raises(InputError, match="no gains within --kp and --kd .*; others do, widen these"):
        robust_gains(platform(), alone(platform()), SPAN, 1e-4 * SPAN, 1.0, TIMING, SMOOTH)
    with pytest.raises(InputError, match="no gains within --kp and --kd .*; others do, widen these"):
        robust_gains(platform(), alone(platform()), np.array([1e4, 2e4]), SPAN, 1.0, TIMING, SMOOTH)


@pytest.mark.slow
def test_asking_for_too_much_is_said() -> None:
    with pytest.raises(InputError, match="no gains put every pole"):
        robust_gains(reaction(), theta_of(reaction(), structure_of(reaction()))[None], AXIS, AXIS, 50.0)
