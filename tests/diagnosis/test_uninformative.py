"""Uninformative logs: what stands above the noise moves, and numbers that run away."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.settings import RemarkSettings
from rwjax.diagnosis.uninformative import diverged_numbers, drowned, moves, part_of, stands_still, why_uninformative
from rwjax.fitting.fit import fit
from tests.diagnosis.simulated import COMMAND, TIME
from tests.systems import record, run, wheel

SETTINGS = RemarkSettings()
SLOW = np.sin(0.5 * TIME)


@pytest.mark.parametrize(
    ("motion", "moved"),
    [
        (np.zeros(len(TIME)), False),
        (1e-3 * SLOW, False),
        (3e-3 * SLOW, True),
        (5e-3 * (np.abs(TIME - 8.0) < 0.25), True),
        (1.0 * TIME, True),
    ],
    ids=["rest", "one deviation", "three deviations", "a short pulse", "turning"],
)
def test_what_stands_above_the_noise_moves(motion: np.ndarray, moved: bool) -> None:
    noise = np.random.default_rng(2).normal(0.0, 1e-3, len(TIME))
    assert moves(record(TIME, COMMAND, {"yaw_rad": 0.3 + motion + noise}), SETTINGS) is moved


def test_a_counter_between_two_counts_does_not_move() -> None:
    step = 2.0 * np.pi / 2048.0
    flicker = record(TIME, COMMAND, {"yaw_rad": step * (TIME % 0.5 < 0.26)})
    assert not moves(replace(flicker, resolution={"yaw_rad": step}), SETTINGS)


def test_numbers_of_a_turning_wheel_do_not_diverge_unless_the_limit_says_so() -> None:
    rig = wheel()
    asked = record(TIME, COMMAND, {"wheel_rad_s": TIME, "current_A": TIME})
    fitted = fit(rig, [record(TIME, COMMAND, run(rig, asked, {}))]).fit
    assert diverged_numbers(rig, fitted, SETTINGS) == ()
    assert diverged_numbers(rig, fitted, replace(SETTINGS, diverged=0.5)) == rig.free


@pytest.mark.parametrize(("inertia", "still"), [(1.24e-4, False), (1e3, True)])
def test_a_wheel_that_its_inertia_holds_stands_still(inertia: float, still: bool) -> None:
    rig = wheel()
    asked = record(TIME, COMMAND, {"wheel_rad_s": TIME, "current_A": TIME})
    rng = np.random.default_rng(3)
    noisy = {
        name: y + rng.normal(0.0, 0.01, len(y)) for name, y in run(rig, asked, {}).items() if name in asked.outputs
    }
    fitted = fit(rig, [record(TIME, COMMAND, noisy)]).fit
    theta = fitted.theta.copy()
    theta[fitted.problem.names.index("wheel.inertia")] = inertia
    assert stands_still(replace(fitted, theta=theta), SETTINGS) is still


def test_the_reason_names_what_hardly_moves() -> None:
    noise = np.random.default_rng(2).normal(0.0, 1e-3, len(TIME))
    still, turning = (record(TIME, COMMAND, {"yaw_rad": motion + noise}) for motion in (0.0, TIME))
    assert why_uninformative([still], (), SETTINGS) == "nothing moves in these logs"
    assert why_uninformative([still, turning], (), SETTINGS) is None
    held = ("wheel.inertia", "motor.friction")
    assert why_uninformative([turning], held, SETTINGS) == f"{part_of(held)} hardly moves in these logs"
    assert part_of(held) == "what wheel.inertia, motor.friction belongs to" and part_of(()) == "the rig"


def test_runs_say_nothing_where_every_floor_is_larger_than_the_motion() -> None:
    angle, rate = 3.0 + np.sin(TIME), np.cos(TIME)  # of 0.7 each about their means
    readings = {"yaw_rad": [angle, np.where(TIME < 1.0, np.nan, angle)], "yaw_rad_s": [rate]}
    readings["yaw_rad"].append(np.full(len(TIME), np.nan))  # a run in which nothing was read
    assert drowned({"yaw_rad": 59.0, "yaw_rad_s": 9.0}, readings)
    assert not drowned({"yaw_rad": 59.0, "yaw_rad_s": 0.1}, readings)
    assert not drowned({"yaw_rad": 0.5, "yaw_rad_s": 0.5}, readings)
