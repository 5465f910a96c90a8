"""When initial states may be free: where the model lacks nothing."""

from functools import cache

import numpy as np
import pytest

from rwjax import Log
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.initial_state_from_start import fit_from_start, is_complete
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from tests.fitting.moving_runs import MOVING, TIME, moving
from tests.systems import platform, record, run

RIG = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')


@cache
def run_of(lacks: float) -> Log:
    """A moving run, with a steady torque [N m] that the rig does not know."""
    log = moving(RIG)
    y = run(RIG, log, MOVING, effects={"axis.bias_torque": {"T": lacks}})["yaw_rad"]
    return record(TIME, log.command, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, 1e-3, len(y))})


@cache
def fitted(lacks: float, from_start: bool) -> Fit:
    """The rig fitted to it, with free initial states or as `fit_from_start` chooses."""
    structure = structure_of(RIG)
    problem, theta = pose(structure, [run_of(lacks)]), theta_of(RIG, structure)
    free = np.array([name in RIG.free for name in structure.names])
    c = coordinates(theta, free, bounds_of(RIG, structure), np.abs(theta) + 1e-3)
    found = least_squares(problem, c, theta)
    return fit_from_start(found) if from_start else found


@pytest.mark.parametrize(("lacks", "complete"), [(0.0, True), (0.05, False)])
def test_a_model_is_complete_where_it_lacks_nothing(lacks: float, complete: bool) -> None:
    assert is_complete(fitted(lacks, False)) is complete
    assert fitted(lacks, True).problem.initial_state_from_start.any() == (not complete)


def test_from_its_start_a_run_of_a_lacking_model_keeps_its_true_initial_state() -> None:
    bent, kept = fitted(0.05, False), fitted(0.05, True)
    assert abs(kept.start[0, 1] - MOVING["w"]) < 0.05 < abs(bent.start[0, 1] - MOVING["w"])
    assert bent.cost < kept.cost
