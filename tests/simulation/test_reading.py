"""Readings between the grid points of the time steps."""

import numpy as np

from tests.systems import platform, record, run, wheel

TIME = np.arange(201) * 0.01


def test_irregular_samples_see_the_motion_of_regular_ones() -> None:
    rng = np.random.default_rng(0)
    fine = np.arange(5001) * 0.002
    u = np.sin(1.3 * fine)
    pick = np.sort(rng.choice(np.arange(1, 5000), size=900, replace=False))
    pick = np.concatenate([[0], pick, [5000]])
    # the command is held between the kept samples: compare with the fine run under that same held command
    held = u[pick][np.searchsorted(pick, np.arange(5001), side="right") - 1]
    reference = run(platform("viscous = 0.02"), record(fine, held), {})["yaw_rad"]
    seen = run(platform("viscous = 0.02"), record(fine[pick], u[pick]), {})["yaw_rad"]
    # one grid step of 5 ms averages the command: acceleration 4 rad/s2 per volt, steps below 0.05 V
    assert np.max(np.abs(seen - reference[pick])) < 0.5 * 4.0 * 0.05 * 0.005


def test_without_inductance_an_irregular_sample_sees_the_current_of_its_own_command() -> None:
    t = np.array([0.0, 0.01, 0.02, 0.03, 0.0427, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1])
    u = np.where(t > 0.0426, -2.0, 2.0)
    y = run(wheel(0.0), record(t, u, {"current_A": np.zeros_like(t)}), {})
    exact = (u - 0.0182 * y["wheel_rad_s"]) / 0.83
    assert np.max(np.abs(y["current_A"] - exact)) < 0.01 * np.ptp(exact)


def test_the_last_current_is_that_of_the_last_command() -> None:
    # without inductance the current follows the voltage at once, at the last sample as at any other
    t = TIME[:51]
    u = np.append(np.full(50, 2.0), -2.0)
    log = record(t, u, {"wheel_rad_s": np.zeros_like(t), "current_A": np.zeros_like(t)})
    y = run(wheel(0.0), log, {})
    assert np.allclose(y["current_A"], (u - 0.0182 * y["wheel_rad_s"]) / 0.83, rtol=1e-12)


def test_a_late_encoder_shows_the_motion_of_a_moment_before() -> None:
    t = np.arange(401) * 0.01
    log = record(t, np.full_like(t, 0.5))
    now = run(platform(), log, {"w": 1.0})["yaw_rad"]
    late = run(platform(), log, {"w": 1.0}, effects={"sensor.delay": {"tau": 0.05}})["yaw_rad"]
    # between grid points the angle is a parabola; the rate is w = 1 rad/s before the log begins
    assert np.max(np.abs(late[5:] - now[:-5])) < 1e-9
    assert np.allclose(late[:5], -0.01 * np.arange(5, 0, -1), atol=1e-12)
