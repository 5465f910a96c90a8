"""A problem whose prior contradicts its log."""

import numpy as np

from rwjax.fitting.coordinates import Coordinates, coordinates
from rwjax.fitting.problem import Problem, pose
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from tests.fitting.logs import FREE, log_of
from tests.systems import platform


def believed_heavier() -> tuple[Problem, Coordinates, np.ndarray]:
    """A problem with an inertia that is known to be 0.12 besides logs that say 0.1, and where its fit begins."""
    rig = platform(free=FREE)
    structure = structure_of(rig)
    problem = pose(structure, (log_of(rig, noise=1e-3),), prior={"axis.inertia": (0.12, 1e-9)})
    theta = theta_of(rig, structure)
    free = np.array([name in rig.free for name in structure.names])
    moves = coordinates(theta, free, bounds_of(rig, structure), np.abs(theta) + 1e-3, prior=True)
    return problem, moves, theta
