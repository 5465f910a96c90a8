"""The floor and what counts as a repeated run."""

import numpy as np
import pytest

from rwjax.fitting.prediction import floor_variance, predict_logs, repeatability
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, record, run

TIME = np.arange(601) * 0.01


PUSH = 0.8 * np.sign(np.sin(2.0 * TIME + 0.1))


def moving(seed: int, speed: float = 1.0, noise: float = 1e-3):
    rig = platform()
    y = run(rig, record(TIME, PUSH), {"w": speed})["yaw_rad"]
    return record(TIME, PUSH, {"yaw_rad": y + np.random.default_rng(seed).normal(0.0, noise, len(y))})


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
