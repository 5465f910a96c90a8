"""Runs that do not start at rest, which several tests of the fit share."""

import numpy as np

from rwjax import Log
from rwjax.fitting.problem import Problem, pose
from rwjax.plant.from_rig import structure_of
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from tests.systems import record, run

TIME = np.arange(600) * 0.01


COMMAND = 0.4 * np.sin(3.0 * TIME) + 0.2


MOVING = {"psi": 0.3, "w": 1.2}


def moving(rig: Rig, start: dict[str, float] | None = None, until: int = 600, noise: float = 1e-3) -> Log:
    """A run that does not start at rest."""
    t, u = TIME[:until], COMMAND[:until]
    y = run(rig, record(t, u), start or MOVING)["yaw_rad"]
    return record(t, u, {"yaw_rad": y + np.random.default_rng(until).normal(0.0, noise, until)})


def several(rig: Rig) -> Problem:
    """Three runs, one of them shorter."""
    return pose(structure_of(rig), [moving(rig), moving(rig, {"w": -0.7}), moving(rig, until=330)])


def alone(problem: Problem, theta: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Residual by the other program, one parameter vector at a time."""
    y, _ = free_run(problem.structure, theta, start, problem.batch)
    return (np.asarray(y) - problem.batch.reading) * problem.batch.weight
