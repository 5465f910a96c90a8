"""States at the windows' starts, read off the logs: where a fit through short windows begins."""

import numpy as np

from rwjax.fitting.problem import Problem
from rwjax.logs.log import Log

HALF_WIDTH = 7
"""Samples on either side of a window's start through which a parabola is laid."""
FEWEST = 5
"""Readings among them below which a state is not read off."""
SAME_TIMES = 1e-12
"""What keeps the parabola through fewer than three times finite, against readings whose squares sum to 1 [1]."""


def _parabolas(log: Log, name: str, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Windows `(w,)` with enough readings of an output, and for these the coefficients `(…, 3)` at the times `at` [s]."""
    t = log.time - log.time[0]
    centre = np.clip(np.searchsorted(t, at), HALF_WIDTH, max(len(t) - 1 - HALF_WIDTH, HALF_WIDTH))
    index = np.clip(centre[:, None] + np.arange(-HALF_WIDTH, HALF_WIDTH + 1), 0, len(t) - 1)
    seen = np.isfinite(log.outputs[name][index])
    enough = seen.sum(axis=1) >= FEWEST
    offset = (t[index] - at[:, None])[enough]
    powers = np.stack([np.ones_like(offset), offset, offset**2], axis=2) * seen[enough, :, None]
    y = np.where(seen[enough], log.outputs[name][index[enough]], 0.0)
    size = np.sqrt(np.sum(powers**2, axis=1, keepdims=True)) + np.finfo(float).tiny
    powers /= size
    across = np.swapaxes(powers, 1, 2)
    normal = across @ powers + SAME_TIMES * np.eye(3)
    return enough, np.linalg.solve(normal, across @ y[..., None])[..., 0] / size[:, 0]


def measured_nodes(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """States at the windows' starts: measured ones from the log, the others from a free run.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI] of the free run.

    Returns:
        States `(l, w, n)` [SI].
    """
    states = problem.structure.states
    nodes = np.full((len(problem.logs), problem.batch.windows, len(states)), np.nan)
    steps = len(problem.batch.step_index)
    for k, log in enumerate(problem.logs):
        at = np.minimum(np.arange(nodes.shape[1]) * steps * problem.batch.h[k], log.time[-1] - log.time[0])
        for angle, rate, angle_name, rate_name in problem.structure.turning:
            for name, entries in ((angle_name, (angle, rate)), (rate_name, (rate,))):
                if name not in log.outputs:
                    continue
                enough, parabola = _parabolas(log, name, at)
                for order, entry in enumerate(entries):
                    nodes[k, enough, states.index(entry)] = parabola[:, order]
    unseen = np.isnan(nodes)
    if unseen.any():
        _, simulated = problem.free_run(theta, problem.start)
        nodes = np.where(unseen, np.nan_to_num(simulated, nan=0.0, posinf=0.0, neginf=0.0), nodes)
    return nodes
