"""States at the windows' starts, read off a log whose motion is known."""

import numpy as np
import pytest

from rwjax.fitting.problem import pose
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, record

TIME = np.arange(501) * 0.01


def test_a_parabola_of_the_angle_gives_angle_and_rate() -> None:
    angle = 0.3 + 0.7 * TIME - 0.2 * TIME**2
    rig = platform()
    structure = structure_of(rig)
    problem = pose(structure, [record(TIME, 0.0 * TIME, {"yaw_rad": angle})])
    nodes = measured_nodes(problem, theta_of(rig, structure))[0]
    begin = np.arange(problem.batch.windows) * len(problem.batch.step_index) * problem.batch.h[0]
    begin = begin[begin < TIME[-1]]
    seen = nodes[: len(begin)]
    assert seen[:, structure.states.index("psi")] == pytest.approx(0.3 + 0.7 * begin - 0.2 * begin**2, abs=1e-9)
    assert seen[:, structure.states.index("w")] == pytest.approx(0.7 - 0.4 * begin, abs=1e-9)


def test_where_no_reading_is_left_the_free_run_takes_over() -> None:
    angle = np.where((TIME > 2.0) & (TIME < 3.0), np.nan, 0.5)
    rig = platform()
    structure = structure_of(rig)
    problem = pose(structure, [record(TIME, 0.0 * TIME, {"yaw_rad": angle})])
    nodes = measured_nodes(problem, theta_of(rig, structure))
    assert np.all(np.isfinite(nodes)) and nodes[0, :, 0] == pytest.approx(0.5, abs=1e-6)  # nothing moves it
