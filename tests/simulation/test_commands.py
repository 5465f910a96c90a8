"""The command as it acts: delays, and what was commanded before the log."""

import numpy as np
import pytest

from tests.systems import platform, record, run

TIME = np.arange(201) * 0.01


def test_a_delay_of_whole_samples_shifts_the_command() -> None:
    t = np.arange(501) * 0.01
    u = np.sign(np.sin(3.0 * t))
    late = np.concatenate([np.full(4, u[0]), u[:-4]])
    delayed = run(platform(), record(t, u), {}, effects={"drive.delay": {"tau": 0.04}})
    assert np.max(np.abs(delayed["yaw_rad"] - run(platform(), record(t, late), {})["yaw_rad"])) < 1e-9


def test_a_small_change_of_delay_moves_the_motion_continuously() -> None:
    u = np.sign(np.sin(3.0 * TIME + 0.1))
    runs = [
        run(platform("viscous = 0.02"), record(TIME, u), {}, effects={"drive.delay": {"tau": tau}})["yaw_rad"]
        for tau in (0.0149, 0.015, 0.0151)  # across a grid point
    ]
    steps = [np.max(np.abs(b - a)) for a, b in zip(runs[:-1], runs[1:], strict=True)]
    # moving jumps of 0.8 N m by 0.1 ms changes w by 0.8 mrad/s; the angle by at most that times 2 s and the jumps
    assert steps[0] == pytest.approx(steps[1], rel=0.02) and 1e-5 < steps[0] < 5e-3


def test_before_the_log_the_first_command_counts_as_held() -> None:
    late = run(platform(), record(TIME, np.full_like(TIME, 0.7)), {}, effects={"drive.delay": {"tau": 0.0437}})
    plain = run(platform(), record(TIME, np.full_like(TIME, 0.7)), {})
    assert np.max(np.abs(late["yaw_rad"] - plain["yaw_rad"])) < 1e-12 * np.ptp(plain["yaw_rad"]) * len(TIME)


def test_a_delayed_command_from_before_a_cut_still_arrives() -> None:
    rig = platform()
    t = np.arange(1001) * 0.01
    u = np.where(t < 5.0, 0.5, -0.8)
    effects = {"drive.delay": {"tau": 0.3}}
    whole = record(t, u)
    y = run(rig, whole, {}, effects=effects)
    cut = 510  # 0.1 s after the command changed, 0.2 s before it acts
    part = whole.cut(cut, len(t))
    start = {"psi": float(y["yaw_rad"][cut]), "w": float(y["yaw_rad_s"][cut])}
    assert run(rig, part, start, effects=effects)["yaw_rad"] == pytest.approx(y["yaw_rad"][cut:], abs=1e-9)
