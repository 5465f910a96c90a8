"""States at the windows' starts, read off the logs: where a fit through short windows begins."""

import numpy as np

from rwjax.fitting.problem import Problem
from rwjax.simulation.shooting import free_run

HALF_WIDTH = 7  # samples on either side of a window's start, through which a parabola is laid


def measured_nodes(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """States at the windows' starts `(l, w, n)`: measured ones from the log, the others from a free run at `theta`."""
    states = problem.structure.states
    nodes = np.full((len(problem.logs), problem.batch.windows, len(states)), np.nan)
    steps = len(problem.batch.step_index)
    for k, log in enumerate(problem.logs):
        at = np.minimum(np.arange(nodes.shape[1]) * steps * problem.batch.h[k], log.time[-1] - log.time[0])
        t = log.time - log.time[0]
        centre = np.clip(np.searchsorted(t, at), HALF_WIDTH, max(len(t) - 1 - HALF_WIDTH, HALF_WIDTH))
        index = np.clip(centre[:, None] + np.arange(-HALF_WIDTH, HALF_WIDTH + 1), 0, len(t) - 1)
        for angle, rate, angle_name, rate_name in problem.structure.turning:
            for name, entries in ((angle_name, (angle, rate)), (rate_name, (rate,))):
                if name not in log.outputs:
                    continue
                seen = np.isfinite(log.outputs[name][index])
                fitted = seen.sum(axis=1) >= 5
                offset = (t[index] - at[:, None])[fitted, :, None]
                powers = np.where(seen[fitted, :, None], offset ** np.arange(3), 0.0)
                y = np.where(seen[fitted], log.outputs[name][index[fitted]], 0.0)
                parabola = np.einsum("wps,ws->wp", np.linalg.pinv(powers), y)
                for order, entry in enumerate(entries):
                    nodes[k, fitted, states.index(entry)] = parabola[:, order]
    unseen = np.isnan(nodes)
    if unseen.any():
        _, simulated = free_run(problem.structure, theta, problem.start, problem.batch)
        nodes = np.where(unseen, np.nan_to_num(simulated, nan=0.0, posinf=0.0, neginf=0.0), nodes)
    return nodes
