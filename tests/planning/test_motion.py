"""How far experiments move a rig, against the closed form of a platform without friction and of one with viscous friction."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.planning.experiment import REST_S, TICK_HZ, Experiment
from rwjax.planning.motion import DECAY_S, TAIL_S, coasting_angle, command_log, peaks, simulated_motion
from tests.joints import as_platform, joint, servo

PUSH = Experiment("coast-down", 2.0, 0.0, 1.0, 3.0)  # 2 V for 1 s
FREE = parse_rig('kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1')


def test_a_log_holds_the_command_and_nothing_after_it() -> None:
    log = command_log(PUSH, "push", 6.0)
    time, volts = PUSH.command()
    assert len(log.time) == 600 and log.outputs == {} and log.name == "push"
    assert np.array_equal(log.command[: len(volts)], volts) and np.all(log.command[len(volts) :] == 0.0)
    assert np.array_equal(command_log(PUSH, "cut", 1.0).command, volts[:100]) and time[1] == 1.0 / TICK_HZ


def test_a_free_platform_moves_as_its_double_integral() -> None:
    begin = np.array([0.0, 0.5])
    moved = simulated_motion(FREE, [PUSH, PUSH], 3.0, begin)
    t = np.arange(300) / TICK_HZ - REST_S
    pushed = np.clip(t, 0.0, 1.0)
    rate = 8.0 * pushed  # 2 V * 0.4 N m/V / 0.1 kg m2
    angle = 0.5 * 8.0 * pushed**2 + rate * np.maximum(t - 1.0, 0.0)
    assert moved["yaw_rad"] == pytest.approx(begin[:, None] + angle, abs=1e-9)
    assert peaks(moved)["yaw_rad"] == pytest.approx(begin + angle[-1]) and moved["yaw_rad_s"].shape == (2, 300)


def test_what_coasts_to_rest_goes_on_by_the_integral_of_its_decay() -> None:
    t = np.arange(round(TICK_HZ * (DECAY_S + 2.0 * TAIL_S))) / TICK_HZ
    left_over = np.full_like(t, 1e-12)  # of a load that friction just holds
    rates = np.stack([3.0 * np.exp(-t / 20.0), np.zeros_like(t), np.full_like(t, 0.1), left_over])
    rest = coasting_angle(rates)
    late = rates[0, -round(TICK_HZ * TAIL_S)]  # the largest rate of the last seconds
    assert rest[0] == pytest.approx(20.0 * late, rel=1e-9)
    assert rest[1] == rest[3] == 0.0 and np.isinf(rest[2])


def test_a_joint_moves_as_the_equal_platform() -> None:
    """Without dry friction and gravity: the time steps of joints are shorter, which only a linear plant does not show."""
    found, same = (simulated_motion(r, [PUSH], 3.0)["yaw_rad"] for r in (joint(), as_platform(joint())))
    np.testing.assert_allclose(found, same, rtol=0.0, atol=1e-9)


def test_a_goal_is_followed_and_then_let_go() -> None:
    """Torque off, a pendulum in viscous friction alone is its exponential."""
    rig = servo(joint(), kp=30.0, period=0.01)
    hold = Experiment("coast-down", 0.5, 0.0, 1.0, 3.0, "goal_rad")
    log = command_log(hold, "hold", 6.0)
    assert log.input == "goal_rad" and log.enabled is not None
    assert log.enabled.sum() == round(TICK_HZ * (REST_S + 1.0)) and hold.words().startswith("coast-down, 0.5 rad")
    moved = simulated_motion(rig, [replace(hold, period=0.1)], 3.0)
    off = round(TICK_HZ * (REST_S + 0.1))
    t = np.arange(300 - off) / TICK_HZ
    w = moved["yaw_rad_s"][0, off:]
    assert w[0] > 0.5
    np.testing.assert_allclose(w, w[0] * np.exp(-t * 0.02 / 0.02), rtol=1e-9)
