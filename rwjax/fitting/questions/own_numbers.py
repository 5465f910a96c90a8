"""A rig file's own numbers as a fit that has not moved: from it sensitivities are taken, or steps."""

from collections.abc import Sequence

import numpy as np

from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import sizes_of
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.logs.segments import cut_up
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig


def at_own_numbers(rig: Rig, logs: Sequence[Log]) -> Fit | None:
    """A fit that has not moved.

    Args:
        rig: The rig with its free numbers.
        logs: The logs that would be fitted.

    Returns:
        The fit; None where nothing is free, nothing was read that is simulated, or the run leaves the range of numbers.

    Raises:
        LogError: The logs have several commands.
    """
    rig, logs = driven(rig, logs)
    structure = structure_of(rig)
    free = np.array([name in rig.free for name in structure.names])
    read = [y for log in logs for name, y in log.outputs.items() if name in structure.outputs]
    if not free.any() or not any(np.isfinite(y).any() for y in read):
        return None
    theta = theta_of(rig, structure)
    size = sizes_of(rig, structure, theta, logs)
    problem = pose(structure, cut_up(logs), prior=rig.prior)
    moves = coordinates(theta, free, bounds_of(rig, structure), size, prior=bool(rig.prior))
    here = least_squares(problem, moves, theta, most_steps=0)
    return here if all(np.isfinite(a).all() for a in here.evaluation) else None  # the questions about units say why
