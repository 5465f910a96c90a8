"""Initial states from the first 0.5 s, by exact sensitivities."""

import numpy as np
import pytest

from rwjax.fitting.initial_state import initial_states_by_sensitivities
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, record, run

TIME = np.arange(601) * 0.01


PUSH = 0.8 * np.sign(np.sin(2.0 * TIME + 0.1))


def moving(seed: int, speed: float = 1.0, noise: float = 1e-3):
    rig = platform()
    y = run(rig, record(TIME, PUSH), {"w": speed})["yaw_rad"]
    return record(TIME, PUSH, {"yaw_rad": y + np.random.default_rng(seed).normal(0.0, noise, len(y))})


@pytest.mark.slow
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
