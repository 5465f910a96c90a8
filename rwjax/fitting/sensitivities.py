"""TODO."""

import numpy as np

from rwjax.fitting.problem import Problem
from rwjax.fitting.threads import on_threads
from rwjax.simulation.batch import Batch
from rwjax.simulation.shooting import Evaluation, evaluate, free_run

COLUMNS = 8
"""Numbers differentiated by come in multiples of this, so that most fits share one compiled program."""
LONG = 4000
"""Steps of a log from which a call of its own costs less than it saves."""


def sensitivities(problem: Problem, theta: np.ndarray, numbers: np.ndarray, nodes: np.ndarray) -> Evaluation:
    """`evaluate` with its columns by the numbers first, zeros up to a multiple of `COLUMNS`, the states last.

    Of several long logs each has a call and a thread of its own; those without readings in the residual are left at 0.
    """
    padded = np.full(max(-(-len(numbers) // COLUMNS), 1) * COLUMNS, len(theta))
    padded[: len(numbers)] = numbers

    def of(nodes: np.ndarray, batch: Batch) -> Evaluation:
        return Evaluation(*(np.asarray(a) for a in evaluate(problem.structure, theta, padded, nodes, batch)))

    batch, told = problem.batch, problem.logs_with_readings.tolist()
    if len(nodes) == 1 or not told or batch.windows * len(batch.step_index) < LONG:
        return of(nodes, batch)
    found = dict(zip(told, on_threads(lambda log: of(nodes[log : log + 1], batch.of(log)), told), strict=True))
    nothing = Evaluation(*(np.zeros_like(a) for a in found[told[0]]))
    every = [found.get(log, nothing) for log in range(len(nodes))]
    axis = {name: 1 if name == "local" else 0 for name in Evaluation._fields}  # of logs
    return Evaluation(*(np.concatenate([getattr(e, name) for e in every], axis[name]) for name in axis))


def run_costs(problem: Problem, theta: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half the sum of squares of each log's free run `(l,)`, and the states at the windows' starts."""
    y, nodes = free_run(problem.structure, theta, start, problem.batch)
    with np.errstate(over="ignore", invalid="ignore"):
        residual = (np.asarray(y) - problem.batch.reading) * problem.batch.weight
        cost = 0.5 * np.sum(residual**2, axis=(1, 2, 3))
    return np.where(np.isfinite(cost), cost, np.inf), np.asarray(nodes)


def residual_jacobian(e: Evaluation, log: int) -> np.ndarray:
    """Derivative of a log's residual by (numbers, first state) through the whole run `(w, q, y, k+n)`."""
    windows, n = e.residual.shape[1], e.chain.shape[2]
    return chained(e.local[:, log], e.chain[log], windows, len(e.local) - n)


def chained(local: np.ndarray, chain: np.ndarray, windows: int, p: int) -> np.ndarray:
    through = np.einsum("nwqy,wnc->wqyc", local[p:, :windows], chain[:windows])
    through[..., :p] += np.moveaxis(local[:p, :windows], 0, -1)
    return through
