"""The start rule, the floor and what counts as a repeated run."""

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.fitting.initial_guess import starts_at_rest
from rwjax.fitting.initial_state import initial_states_by_sensitivities
from rwjax.fitting.predict import predict
from rwjax.fitting.prediction import floor_variance, predict_logs, repeatability
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, reaction, record, run

TIME = np.arange(601) * 0.01
PUSH = 0.8 * np.sign(np.sin(2.0 * TIME + 0.1))


def moving(seed: int, speed: float = 1.0, noise: float = 1e-3):
    rig = platform()
    y = run(rig, record(TIME, PUSH), {"w": speed})["yaw_rad"]
    return record(TIME, PUSH, {"yaw_rad": y + np.random.default_rng(seed).normal(0.0, noise, len(y))})


def test_nothing_after_the_first_half_second_is_looked_at() -> None:
    rig = reaction()
    u = 8.0 * PUSH
    asked = record(TIME, u, {"yaw_rad": np.zeros_like(TIME), "current_A": np.zeros_like(TIME)})
    y = run(rig, asked, {"w": 0.3, "i": 1.0})
    rng = np.random.default_rng(0)
    noisy = {name: y[name] + rng.normal(0.0, 1e-3, len(TIME)) for name in asked.outputs}
    plain = predict(rig, record(TIME, u, noisy))
    late = TIME > 0.5
    changed = {name: value + np.where(late, rng.normal(0.0, 0.5, len(TIME)), 0.0) for name, value in noisy.items()}
    again = predict(rig, record(TIME, u, changed))
    for name in ("yaw_rad", "current_A"):
        assert again[name] == pytest.approx(plain[name], abs=1e-9)


def test_the_start_of_one_log_does_not_depend_on_the_others() -> None:
    rig = platform()
    logs = [moving(seed, speed) for seed, speed in enumerate((1.0, -2.0, 0.2, 5.0))]
    structure = structure_of(rig)
    together = initial_states_by_sensitivities(pose(structure, logs), theta_of(rig, structure))
    for k, log in enumerate(logs):
        alone = initial_states_by_sensitivities(pose(structure, (log,)), theta_of(rig, structure))
        assert together[k] == pytest.approx(alone[0], abs=1e-6)


def test_the_start_is_found_within_its_uncertainty() -> None:
    rig = platform()
    structure = structure_of(rig)
    speeds = [
        initial_states_by_sensitivities(pose(structure, (moving(seed),)), theta_of(rig, structure))[0, 1]
        for seed in range(30)
    ]
    assert abs(np.mean(speeds) - 1.0) < 4.0 * np.std(speeds) / np.sqrt(30)
    # slope of a line through 51 readings of noise 1e-3 over 0.5 s
    assert np.std(speeds) == pytest.approx(1e-3 / (np.std(TIME[:51]) * np.sqrt(51)), rel=0.5)


def test_a_true_model_leaves_its_floor() -> None:
    rig = platform()
    structure = structure_of(rig)
    logs = tuple(moving(seed) for seed in range(12))
    problem = pose(structure, logs)
    found = predict_logs(problem, theta_of(rig, structure))
    floor = floor_variance(problem, found)
    left = np.mean(
        [np.mean((log.outputs["yaw_rad"] - p.outputs["yaw_rad"]) ** 2) for log, p in zip(logs, found, strict=True)]
    )
    promised = np.mean([np.mean(f["yaw_rad"]) for f in floor])
    assert left == pytest.approx(promised, rel=0.6)


def test_coast_downs_of_different_speed_do_not_repeat_one_another() -> None:
    rig = platform()
    still = np.zeros_like(TIME)
    coasts = tuple(
        record(TIME, still, {"yaw_rad": run(rig, record(TIME, still), {"w": w})["yaw_rad"]}) for w in (1.0, 2.0, 3.0)
    )
    assert repeatability(coasts) == {}
    u = np.where(TIME > 0.6, PUSH, 0.0)
    y = run(rig, record(TIME, u), {})["yaw_rad"]
    rng = np.random.default_rng(0)
    repeats = tuple(
        record(TIME, u, {"yaw_rad": y + 0.01 * rng.normal() * np.maximum(TIME - 0.6, 0.0)}) for _ in range(3)
    )
    scatter = [float(np.sqrt(np.mean(variance))) for _, variance in repeatability(repeats)["yaw_rad"]]
    assert 0.005 < scatter[0] < 0.1


def test_an_offset_of_the_current_does_not_set_a_run_in_motion() -> None:
    u = np.where(TIME > 0.6, 3.0, 0.0)
    log = record(TIME, u, {"yaw_rad": np.zeros_like(TIME), "current_A": np.full_like(TIME, 0.02)})
    assert starts_at_rest(log)
    assert not starts_at_rest(record(TIME, u + 0.004, log.outputs))


def test_gravity_acts_on_an_angle_that_was_not_logged() -> None:
    rig = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02\n'
        "[axis.gravity]\ntorque = 0.5\nangle = 0.0"
    )
    still = np.zeros_like(TIME)
    asked = record(TIME, still, {"yaw_rad_s": still})
    y = run(rig, asked, {"psi": 1.0})["yaw_rad_s"]
    found = predict(rig, record(TIME, still, {"yaw_rad_s": y}))["yaw_rad_s"]
    assert found == pytest.approx(y, abs=1e-4)
