"""Free runs of a problem with their cost, and the derivatives of its residual."""

import numpy as np

from rwjax.fitting.problem import Problem
from rwjax.fitting.threads import on_threads
from rwjax.simulation.batch import Batch
from rwjax.simulation.shooting import Evaluation, evaluate, of_logs


def run_costs(problem: Problem, theta: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cost of each log's free run, without the prior, and the states at its windows' starts.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        start: Initial states `(l, n)` [SI].

    Returns:
        Half the sum of squared residuals `(l,)` [1], infinite where a run leaves the range of numbers, and states
        `(l, w, n)` [SI].
    """
    y, nodes = problem.free_run(theta, start)
    with np.errstate(over="ignore", invalid="ignore"):
        residual = (y - problem.batch.reading) * problem.batch.weight
        cost = 0.5 * np.sum(residual**2, axis=(1, 2, 3))
    return np.where(np.isfinite(cost), cost, np.inf), nodes


def sensitivities(problem: Problem, theta: np.ndarray, numbers: np.ndarray, nodes: np.ndarray) -> Evaluation:
    """`evaluate` of a problem's logs, as numpy arrays.

    Its columns are the derivatives by the numbers, zeros where XLA's program fills them up, and the derivatives by the
    states. Several long logs run at the same time, each in a call of its own; logs without readings are left at 0.

    Args:
        problem: Logs and structure.
        theta: Parameter vector `(t,)` [SI].
        numbers: Entries of `theta` to differentiate by `(k,)` [index].
        nodes: States at the windows' starts `(l, w, n)` [SI].

    Returns:
        Residuals in units of noise [1] and their derivatives [1/SI].
    """

    def of(nodes: np.ndarray, batch: Batch) -> Evaluation:
        return Evaluation(
            *(np.asarray(a) for a in evaluate(problem.structure, theta, numbers, nodes, batch, solver=problem.solver))
        )

    batch, counted = problem.batch, problem.logs_with_readings.tolist()
    if not counted or not problem.log_by_log:
        return of(nodes, batch)
    found = dict(zip(counted, on_threads(lambda log: of(nodes[log : log + 1], batch.of(log)), counted), strict=True))
    nothing = Evaluation(*(np.zeros_like(a) for a in found[counted[0]]))
    return of_logs([found.get(log, nothing) for log in range(len(nodes))])


def residual_jacobian(
    e: Evaluation, log: int, along: np.ndarray | None = None, windows: int | None = None
) -> np.ndarray:
    """Derivative of a log's residual by the numbers and its initial state, or along some changes of them, through the whole run.

    Args:
        e: Derivatives window by window.
        log: Number of the log.
        along: The changes `(k+n, m)` [SI], one in each column; without it every number and every state by itself.
        windows: How many windows, from the first one on; all without it [1].

    Returns:
        Derivative `(w, q, y, m)` [1/SI].
    """
    local, chain = e.local[:, log, :windows], e.chain[log, :windows]
    columns, W, *slots = local.shape
    along = np.eye(columns) if along is None else along
    numbers = along[: columns - chain.shape[1]]
    change = np.concatenate([np.broadcast_to(numbers, (W, *numbers.shape)), chain @ along], axis=1)  # in each window
    return (local.reshape(columns, W, -1).transpose(1, 2, 0) @ change).reshape(W, *slots, -1)
