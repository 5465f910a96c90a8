"""The loop as it runs with the rig's own delays: its poles against the eigenvalues of a matrix written out by hand."""

import numpy as np
import pytest
from scipy.linalg import expm

from rwjax import parse_rig
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import pd_loop
from rwjax.control.margins import sampled_modulus
from rwjax.control.robustness import robustness
from rwjax.control.sampled_loop import SampledLaw, sampled_loop, sampled_loops, sampled_pid_loop, stacked_loops
from rwjax.control.stability import share_of_sampled, stable_sampled
from rwjax.control.transfer import transfer
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from tests.control.delayed_platform import GAIN, INERTIA, SMOOTH, TIMING, VISCOUS, H, with_delays
from tests.control.thesis_axis import THESIS

KP, KI, KD = 6.0, 2.0, 2.0
CASES = [(0.0, 0.0), (0.003, 0.0), (0.0, 0.005), (0.0125, 0.005), (0.08, 0.0)]  # s, of the command and of the reading


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
    (loop,) = sampled_loops(with_delays(*delays), SampledLaw(TIMING, SMOOTH, integral=True))
    poles, exact = 1.0 + loop.poles(KP, KI, KD), np.linalg.eigvals(by_hand(0.005 + sum(delays)))
    large = exact[np.abs(exact) > 0.05]  # those at 0 spread by rounding
    assert len(large) >= 4
    for pole in large:
        assert np.min(np.abs(poles - pole)) < 1e-6


@pytest.mark.parametrize("delays", [d for d in CASES if d != (0.003, 0.0)])  # of whole steps: the run's mean is exact
def test_the_nonlinear_loop_has_the_same_delays(delays: tuple[float, float]) -> None:
    law = Controller(KP, ki=KI, kd=KD, filter_time=SMOOTH)
    run = np.asarray(run_rig(with_delays(*delays), law, np.zeros(400), TIMING, psi=0.1).angle)
    M = by_hand(0.005 + sum(delays))
    state = np.zeros(len(M))
    state[[0, 3]] = 0.1, -0.1  # no slope at first
    expected = []
    for _ in run:
        expected.append(state[0])
        state = M @ state
    assert run == pytest.approx(expected, rel=1e-9, abs=1e-10 * np.max(np.abs(expected)))


@pytest.mark.slow
def test_plants_of_many_delays_are_judged_by_their_own() -> None:
    rig = with_delays(0.003, 0.005)
    structure = structure_of(rig)
    thetas = np.tile(theta_of(rig, structure), (5, 1))
    thetas[:, structure.names.index("drive.delay.tau")] = [0.0, 0.003, 0.012, 0.03, 0.06]
    each, grid = sampled_loops(rig, SampledLaw(TIMING, SMOOTH), thetas), np.linspace(1.0, 60.0, 12)
    alone = [stable_sampled(loop, grid[:, None], grid[None, :]) for loop in each]
    assert np.array_equal(share_of_sampled(stacked_loops(each), grid, grid), np.mean(alone, axis=0))
    counts = [int(one.sum()) for one in alone]
    assert counts == sorted(counts, reverse=True) and len(set(counts)) == 5 and counts[-1] > 0
    law = Controller(KP, kd=KD, filter_time=SMOOTH)
    worst = min(sampled_modulus(loop, KP, KD) for loop in each)
    assert robustness(rig, thetas, TIMING, law) == (1.0, pytest.approx(worst))


def test_a_delay_of_too_many_periods_is_said() -> None:
    with pytest.raises(InputError, match=r"commands act 0\.205 s after their reading, more than 12 periods of 0\.01 s"):
        sampled_loops(with_delays(0.2, 0.0), SampledLaw(TIMING))


def test_sampling_fast_is_not_sampling() -> None:
    plant = transfer(linearised(THESIS))
    slow = np.sort_complex(pd_loop(plant).poles(40.0, 10.0))
    error = []
    for h in (1e-2, 1e-3, 1e-4):
        z = 1.0 + sampled_loop(plant, h).poles(40.0, 10.0)
        s = np.sort_complex(np.log(z[np.abs(z) > 0.05]) / h)
        error.append(np.max(np.abs(s - slow)))
    assert error[1] == pytest.approx(0.1 * error[0], rel=0.2) and error[2] == pytest.approx(0.1 * error[1], rel=0.2)


@pytest.mark.parametrize("late", [0.0, 0.004, 0.01, 0.013, 0.02])
def test_a_sampled_loop_is_what_the_recursion_does(late: float) -> None:
    """The same loop step by step: exact motion of a double integrator under the held, late command."""
    rig = parse_rig('kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1')
    plant, h = transfer(linearised(rig)), 0.01
    loop, gain = sampled_loop(plant, h, late), 4.0
    whole, part = int(late // h), late % h
    for kp, kd in ((3.0, 2.0), (30.0, 1.0), (5.0, 60.0)):
        x, v, before, held = 1.0, 0.0, 1.0, [0.0] * 4
        size = []
        for _ in range(4000):
            held = [-(kp * x + kd * (x - before) / h), *held[:3]]
            before = x
            for u, time in ((held[whole + 1], part), (held[whole], h - part)):
                x, v = x + v * time + 0.5 * gain * u * time**2, v + gain * u * time
            size.append(abs(x))
            if abs(x) > 1e9:
                break
        largest = np.max(np.abs(1.0 + loop.poles(kp, kd)))
        assert (largest < 1.0) == (size[-1] < 1.0)
        found = stable_sampled(loop, np.array([kp]), np.array([kd]))
        assert bool(found[0]) == (largest < 1.0)


def test_a_filtered_sampled_loop_with_an_integral_is_what_runs() -> None:
    rig = parse_rig('kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02')
    law = Controller(6.0, ki=2.0, kd=2.0, filter_time=0.03)
    run = np.asarray(run_rig(rig, law, np.zeros(400), LoopTiming(delay_steps=2.0), psi=0.1).angle)
    poles = 1.0 + sampled_pid_loop(transfer(linearised(rig)), 0.01, 0.005, 0.03).poles(6.0, 2.0, 2.0)
    p = np.poly(poles).real  # the angle's recursion
    rest = [np.dot(p, run[k - len(p) + 1 : k + 1][::-1]) for k in range(100, 400)]
    assert np.max(np.abs(rest)) < 1e-9 < np.max(np.abs(run[100:]))
