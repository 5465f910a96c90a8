"""Runs that do not start at rest, which several tests of the fit share."""

import numpy as np

from rwjax import Log
from rwjax.fitting.coordinates import Coordinates, coordinates
from rwjax.fitting.problem import Problem, pose
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from tests.systems import platform, record, run

TIME = np.arange(600) * 0.01


COMMAND = 0.4 * np.sin(3.0 * TIME) + 0.2


SMOOTH = platform("viscous = 0.02")
STEP_OF_COMMAND = 0.04
"""Step from one command to the next of `starting_with_a_jump` [V]."""
MOVING = {"psi": 0.3, "w": 1.2}


def moving(rig: Rig, start: dict[str, float] | None = None, until: int = 600, noise: float = 1e-3) -> Log:
    """A run that does not start at rest."""
    t, u = TIME[:until], COMMAND[:until]
    y = run(rig, record(t, u), start or MOVING)["yaw_rad"]
    return record(t, u, {"yaw_rad": y + np.random.default_rng(until).normal(0.0, noise, until)})


def several(rig: Rig) -> Problem:
    """Three runs, one of them shorter."""
    return pose(structure_of(rig), [moving(rig), moving(rig, {"w": -0.7}), moving(rig, until=330)])


def starting_with_a_jump(jump: float) -> Problem:
    """A run without noise of a drive that starts with a jump [V], by a command that goes up and down in steps."""
    up_and_down = np.abs((np.arange(600) + 50) % 100 - 50) - 25
    log = record(TIME, np.where(TIME > 0.6, (up_and_down + 0.3) * STEP_OF_COMMAND, 0.0))
    y = run(SMOOTH, log, {}, effects={"drive.deadzone": {"j": jump}})
    structure = structure_of(SMOOTH).with_effects("drive.deadzone")
    return pose(structure, [record(log.time, log.command, {"yaw_rad": y["yaw_rad"]})], {"yaw_rad": 1e-3})


def with_jump(problem: Problem, jump: float) -> tuple[np.ndarray, Coordinates]:
    """Numbers of `starting_with_a_jump` with another jump [V], which alone is free."""
    theta = theta_of(SMOOTH, problem.structure)
    free = np.array([name == "drive.deadzone.j" for name in problem.structure.names])
    theta[free] = jump
    return theta, coordinates(theta, free, bounds_of(SMOOTH, problem.structure), np.full(len(theta), 0.25))


def alone(problem: Problem, theta: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Residual by the other program, one parameter vector at a time."""
    y, _ = free_run(problem.structure, theta, start, problem.batch)
    return (np.asarray(y) - problem.batch.reading) * problem.batch.weight
