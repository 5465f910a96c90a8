"""The loop as it runs with the rig's own delays: its poles against the eigenvalues of a matrix written out by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from rwjax import Rig, parse_rig
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.criteria import ContinuousPoles, SampledPoles
from rwjax.control.linear import linearised
from rwjax.control.margins import pd_margins, sampled_modulus
from rwjax.control.region import pd_region
from rwjax.control.robustness import robustness
from rwjax.control.sampled_loop import sampled_loops, stacked_loops
from rwjax.control.stability import share_of_plants, share_of_sampled, stable_sampled
from rwjax.control.transfer import transfer
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of

GAIN, INERTIA, VISCOUS, H, SMOOTH = 0.4, 0.1, 0.02, 0.01, 0.03
RIG = parse_rig(
    f'kind = "platform"\n[drive]\ngain = {GAIN}\n[axis]\ninertia = {INERTIA}\n[axis.friction]\nviscous = {VISCOUS}'
)
KP, KI, KD = 6.0, 2.0, 2.0
CLOCK = LoopTiming(H, delay_steps=2.0)  # 5 ms
CASES = [(0.0, 0.0), (0.003, 0.0), (0.0, 0.005), (0.0125, 0.005), (0.08, 0.0)]  # s, of the command and of the reading


def with_delays(command: float, reading: float) -> Rig:
    return replace(RIG, effects={"drive.delay": {"tau": command}, "sensor.delay": {"tau": reading}})


def turned(x: np.ndarray, u: np.ndarray, time: float) -> np.ndarray:
    """Rows of angle and rate after a time under a command, as rows of what they are made of."""
    A = np.array([[0.0, 1.0, 0.0], [0.0, -VISCOUS / INERTIA, GAIN / INERTIA], [0.0, 0.0, 0.0]])
    return (expm(A * time) @ np.vstack([x, u]))[:2]


def by_hand(delay: float) -> np.ndarray:
    """What the loop makes of (angle, rate, slope, error and integral before, commands before) in a period."""
    whole = int(delay / H + 1e-9)
    part, n = delay - whole * H, 5 + whole + 1
    one = np.eye(n)
    error = -one[0]
    slope = (SMOOTH * one[2] + error - one[3]) / (SMOOTH + H)
    commands = [KP * error + KI * one[4] + KD * slope, *one[5:]]
    x = turned(turned(one[:2], commands[whole + 1], part), commands[whole], H - part)
    return np.vstack([x, slope, error, one[4] + H * error, *commands[:-1]])


@pytest.mark.parametrize("delays", CASES)
def test_poles_are_the_eigenvalues_of_the_loop_with_its_delays(delays: tuple[float, float]) -> None:
    (loop,) = sampled_loops(with_delays(*delays), CLOCK, SMOOTH, integral=True)
    poles, exact = 1.0 + loop.poles(KP, KI, KD), np.linalg.eigvals(by_hand(0.005 + sum(delays)))
    large = exact[np.abs(exact) > 0.05]  # those at 0 spread by rounding
    assert len(large) >= 4
    for pole in large:
        assert np.min(np.abs(poles - pole)) < 1e-6


@pytest.mark.parametrize("delays", [d for d in CASES if d != (0.003, 0.0)])  # of whole steps: the run's mean is exact
def test_the_nonlinear_loop_has_the_same_delays(delays: tuple[float, float]) -> None:
    law = Controller(KP, ki=KI, kd=KD, filter_time=SMOOTH)
    run = np.asarray(run_rig(with_delays(*delays), law, np.zeros(400), CLOCK, psi=0.1).angle)
    M = by_hand(0.005 + sum(delays))
    state = np.zeros(len(M))
    state[[0, 3]] = 0.1, -0.1  # no slope at first
    expected = []
    for _ in run:
        expected.append(state[0])
        state = M @ state
    assert run == pytest.approx(expected, rel=1e-9, abs=1e-10 * np.max(np.abs(expected)))


def test_plants_of_many_delays_are_judged_by_their_own() -> None:
    rig = with_delays(0.003, 0.005)
    structure = structure_of(rig)
    thetas = np.tile(theta_of(rig, structure), (5, 1))
    thetas[:, structure.names.index("drive.delay.tau")] = [0.0, 0.003, 0.012, 0.03, 0.06]
    each, grid = sampled_loops(rig, CLOCK, SMOOTH, thetas), np.linspace(1.0, 60.0, 12)
    alone = [stable_sampled(loop, grid[:, None], grid[None, :]) for loop in each]
    assert np.array_equal(share_of_sampled(stacked_loops(each), grid, grid), np.mean(alone, axis=0))
    counts = [int(one.sum()) for one in alone]
    assert counts == sorted(counts, reverse=True) and len(set(counts)) == 5 and counts[-1] > 0
    law = Controller(KP, kd=KD, filter_time=SMOOTH)
    worst = min(sampled_modulus(loop, KP, KD) for loop in each)
    assert robustness(rig, thetas, CLOCK, law) == (1.0, pytest.approx(worst))


def test_a_delay_of_too_many_periods_is_said() -> None:
    with pytest.raises(InputError, match=r"commands act 0\.205 s after their reading, more than 12 periods of 0\.01 s"):
        sampled_loops(with_delays(0.2, 0.0), CLOCK)


GRID, RATES = np.linspace(0.0, 60.0, 13), np.linspace(0.0, 12.0, 13)


def test_a_sampled_region_holds_the_rig_s_delay_and_its_margins() -> None:
    asked = SampledPoles(1.0, CLOCK, SMOOTH)
    late = with_delays(0.02, 0.0)
    found, without = asked.region(late, GRID, GRID), asked.region(RIG, GRID, GRID)
    assert 5 < found.stable.sum() < without.stable.sum() - 5
    (loop,) = sampled_loops(late, CLOCK, SMOOTH)
    margins = asked.margins(late, found)["modulus"]
    for (i, kp), (j, kd) in ((a, b) for a in enumerate(GRID) for b in enumerate(GRID)):
        size = np.max(np.abs(1.0 + loop.poles(kp, kd)))
        assert found.stable[i, j] == (size < np.exp(-0.01)) and np.isnan(margins[i, j]) == (not found.stable[i, j])
        if found.stable[i, j]:
            assert margins[i, j] == pytest.approx(sampled_modulus(loop, kp, kd))
    thetas = theta_of(late, structure_of(late))[None]
    assert np.array_equal(asked.share(late, thetas, GRID, GRID) == 1.0, found.stable)


def test_without_a_derivative_its_filter_is_none_of_the_loop() -> None:
    kp, kd, rig = np.array([0.05, 0.1]), np.array([0.0, 0.05]), RIG.with_values({"axis.friction.viscous": 0.1})
    slow, fast = SampledPoles(0.25, CLOCK, 5.0), SampledPoles(0.25, CLOCK, 0.0)
    found, thetas = slow.region(rig, kp, kd), theta_of(rig, structure_of(rig))[None]
    assert np.array_equal(found.stable[:, 0], fast.region(rig, kp, kd).stable[:, 0]) and found.stable[1, 0]
    assert np.array_equal(slow.share(rig, thetas, kp, kd) == 1.0, found.stable)


def test_a_damped_region_and_its_margins() -> None:
    plain, damped = (ContinuousPoles(0.5, damping).region(RIG, GRID, RATES) for damping in (0.0, 0.7))
    plant = transfer(linearised(RIG))
    ratio = np.array([[_damping(kp, kd) for kd in RATES] for kp in GRID])
    clear = np.abs(ratio - 0.7) > 1e-9
    assert np.array_equal(damped.stable[clear], (plain.stable & (ratio > 0.7))[clear])
    assert 5 < damped.stable.sum() < plain.stable.sum() - 5
    assert np.array_equal(pd_region(RIG, GRID, RATES, 0.5).stable, plain.stable)
    i, j = np.argwhere(damped.stable)[3]
    margins, own = ContinuousPoles(0.5, 0.7).margins(RIG, damped), pd_margins(plant, GRID[i], RATES[j])
    assert [float(margins[name][i, j]) for name in margins] == [*own.gain, own.phase, own.delay, own.modulus]
    thetas = np.tile(theta_of(RIG, structure_of(RIG)), (3, 1))
    thetas[:, structure_of(RIG).names.index("axis.inertia")] *= [0.5, 1.0, 2.0]
    plants = transfer(linearised(RIG, thetas=thetas))
    share = share_of_plants(plants, GRID, RATES, 0.5, 0.7)
    others = [
        ContinuousPoles(0.5, 0.7).region(RIG.with_values({"axis.inertia": f * INERTIA}), GRID, RATES)
        for f in (0.5, 1.0, 2.0)
    ]
    assert np.array_equal(share, np.mean([one.stable.astype(float) for one in others], axis=0))


def _damping(kp: float, kd: float) -> float:
    """Least damping ratio of I s² + (b + k K_d) s + k K_p."""
    poles = np.roots([INERTIA, VISCOUS + GAIN * kd, GAIN * kp])
    return float(np.min(-poles.real / np.maximum(np.abs(poles), 1e-300)))
