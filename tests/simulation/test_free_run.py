"""Free runs of whole logs and of their first windows."""

import numpy as np
import pytest

from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.free_run import free_run, free_runs
from tests.systems import platform, record

T = np.arange(101) * 0.01
EFFECTS = {"windows": (), "late readings": ("sensor.delay",)}


@pytest.mark.parametrize("case", EFFECTS)
def test_the_first_windows_are_those_of_the_whole_run(case: str) -> None:
    structure = structure_of(platform()).with_effects(*EFFECTS[case])
    theta = theta_of(platform(), structure)
    theta = np.where(np.array(structure.names) == "sensor.delay.tau", 0.03, theta)
    logs = [record(T, u, {"yaw_rad": np.zeros_like(T)}) for u in (np.full_like(T, 0.5), np.sin(9.0 * T))]
    batch = pose(structure, logs, {"yaw_rad": 1.0}).batch
    start = np.array([[0.0, 1.0], [0.2, -1.0]])
    whole, nodes = (np.asarray(a) for a in free_run(structure, theta, start, batch))
    other = theta * np.where(np.array(structure.names) == "axis.inertia", 1.1, 1.0)
    first = free_runs(structure, np.stack([theta, other]), start[[1, 1]], 2, batch.of(1))
    assert batch.windows > 2 and nodes.shape == (2, batch.windows, 2) and first.shape[1] == 2
    assert first[0] == pytest.approx(whole[1, :2], rel=1e-12, abs=1e-15)
    assert np.max(np.abs(first[1] - whole[1, :2])) > 1e-4  # numbers of its own
