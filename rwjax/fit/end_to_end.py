"""End-to-end fit: free-run least squares over whole logs, through short windows first.

Two phases of one Gauss-Newton iteration with Levenberg-Marquardt damping. First every window starts from a state read
off the log and only linearised continuity ties it to the next (condensed multiple shooting: a wide basin of
attraction). Then the windows' states are those of the free run itself, so that the sum of squares is the free run's and
falls with every accepted step. The loop runs on the host and calls two compiled programs: an optimistix solver would
need the residual of the whole log as one function, whose Jacobian by plain forward mode costs the time of a sequential
run for every number (see docs/design.md for the measurement).
"""

from dataclasses import dataclass, replace

import numpy as np

from rwjax.fit.coordinates import Coordinates
from rwjax.fit.kinks import across_kinks
from rwjax.fit.problem import Problem
from rwjax.simulate import Evaluation, evaluate, free_run

WINDOW_STEPS = 8
COLUMNS = 8
"""Numbers differentiated by come in multiples of this, so that most fits share one compiled program."""
LARGEST_DAMPING = 1e8
MISFIT = 1.5
"""Mean square in units of noise above which creases of the sum of squares may have stopped a fit early."""


@dataclass(frozen=True)
class Fit:
    """Result of a fit. `theta` all numbers in the order of `structure.names`, `start` first state of each log.

    `cost`: half the sum of squared residuals in units of noise. `evaluation`: sensitivities at the optimum, windows
    started from the free run (numpy arrays). `converged`: False where the step limit came first. `damping`: of the last
    step, with which a fit that goes on begins.
    """

    problem: Problem
    coordinates: Coordinates
    theta: np.ndarray
    start: np.ndarray
    cost: float
    evaluation: Evaluation
    converged: bool
    steps: int
    damping: float

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free numbers."""
        return tuple(self.problem.structure.names[k] for k in self.coordinates.index)

    def numbers(self) -> dict[str, float]:
        """All numbers by name."""
        return dict(zip(self.problem.structure.names, (float(v) for v in self.theta), strict=True))


def sensitivities(problem: Problem, theta: np.ndarray, numbers: np.ndarray, nodes: np.ndarray) -> Evaluation:
    """`evaluate` with its columns by the numbers first, zeros up to a multiple of `COLUMNS`, the states last."""
    padded = np.full(max(-(-len(numbers) // COLUMNS), 1) * COLUMNS, len(theta))
    padded[: len(numbers)] = numbers
    return Evaluation(*(np.asarray(a) for a in evaluate(problem.structure, theta, padded, nodes, problem.batch)))


def _run(problem: Problem, theta: np.ndarray, start: np.ndarray) -> tuple[float, np.ndarray]:
    """Half the sum of squares of the free run, and the states at the windows' starts."""
    y, nodes = free_run(problem.structure, theta, start, problem.batch)
    with np.errstate(over="ignore", invalid="ignore"):
        residual = (np.asarray(y) - problem.batch.reading) * problem.batch.weight
        cost = 0.5 * float(np.sum(residual**2))
    return (cost if np.isfinite(cost) else np.inf), np.asarray(nodes)


def _sticks(problem: Problem, theta: np.ndarray) -> bool:
    """Whether any dry friction acts: without it the sum of squares has no creases."""
    dry = ("friction.coulomb", "friction.static", "friction.b3", ".M_c", ".M_e")
    return any(name.endswith(dry) and value > 0.0 for name, value in zip(problem.structure.names, theta, strict=True))


def _solve(
    e: Evaluation, coordinates: Coordinates, theta: np.ndarray, start_free: np.ndarray, damping: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """Damped Gauss-Newton step: change of the coordinates, and of each log's first state.

    Numbers on a bound that the step would leave through are held; first states are eliminated log by log.
    """
    k = np.arange(len(coordinates.index))
    scale = coordinates.slope(theta)
    L, n = start_free.shape
    p = e.g.shape[1] - n
    held = np.zeros(len(k), bool)
    low, high = coordinates.on_bound(theta)
    for _ in range(len(k) + 1):
        A = np.zeros((len(k), len(k)))
        b = np.zeros(len(k))
        parts = []
        for log in range(L):
            s = np.flatnonzero(start_free[log])
            H, g = e.H[log], e.g[log]
            Htt = H[np.ix_(k, k)] * scale[:, None] * scale
            Hts = H[np.ix_(k, p + s)] * scale[:, None]
            Hss = H[np.ix_(p + s, p + s)]
            diagonal = np.diag(Hss)
            ridge = damping * diagonal + 1e-12 * max(np.max(diagonal, initial=0.0), 1e-300)
            inverse = np.linalg.pinv(Hss + np.diag(ridge), hermitian=True) if len(s) else np.zeros((0, 0))
            A += Htt - Hts @ inverse @ Hts.T
            A[np.diag_indices(len(k))] += damping * np.diag(Htt)
            b += g[k] * scale - Hts @ inverse @ g[p + s]
            parts.append((s, inverse, Hts, g[p + s]))
        if not (np.all(np.isfinite(A)) and np.all(np.isfinite(b))):
            return None
        move = np.flatnonzero(~held)
        dz = np.zeros(len(k))
        if len(move):
            M = A[np.ix_(move, move)]
            d = np.sqrt(np.maximum(np.diag(M), 1e-300))
            dz[move] = -np.linalg.lstsq(M / d / d[:, None], b[move] / d, rcond=1e-13)[0] / d
        leaving = ~held & ((low & (dz < 0.0)) | (high & (dz > 0.0)))
        if not leaving.any():
            break
        held |= leaving
    dx = np.zeros((L, n))
    for log, (s, inverse, Hts, g) in enumerate(parts):
        dx[log, s] = -inverse @ (g + Hts.T @ dz)
    return dz, dx


def _through_windows(
    problem: Problem, c: Coordinates, theta: np.ndarray, nodes: np.ndarray, start_free: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """First phase: a few steps from states read off the log. Returns numbers and first states."""
    damping = 1e-3
    for _ in range(WINDOW_STEPS):
        e = sensitivities(problem, theta, c.index, nodes)
        step = _solve(e, c, theta, start_free, damping)
        if step is None:
            break
        dz, dx = step
        share = c.shorten(dz)
        theta_new = c.move(theta, share * dz)
        change = np.zeros(e.g.shape)
        change[:, : len(c.index)] = (theta_new - theta)[c.index]
        change[:, -dx.shape[1] :] = share * dx
        nodes_new = nodes + np.einsum("lwna,la->lwn", e.chain, change) + share * e.shift
        if not np.all(np.isfinite(nodes_new)):
            break
        theta, nodes = theta_new, nodes_new
        if np.max(np.abs(dz), initial=0.0) < 1e-3:
            break
    return theta, nodes[:, 0]


def fit(
    problem: Problem,
    coordinates: Coordinates,
    theta: np.ndarray,
    *,
    start: np.ndarray | None = None,
    nodes: np.ndarray | None = None,
    damping: float = 1e-3,
    most_steps: int = 60,
    tolerance: float = 1e-7,
    creases: bool = False,
) -> Fit:
    """Least squares of the free run over the free numbers and the logs' first states.

    With `nodes` (l, w, n) given, the short windows come first and the better of both starts is kept. With `creases`, a
    fit that ends well above the noise goes on by steps across the creases of stick and slip.
    """
    start = problem.start if start is None else start
    start_free = problem.start_free
    theta = coordinates.inward(theta)
    cost, states = _run(problem, theta, start)
    if nodes is not None:
        nodes = nodes.copy()
        nodes[:, 0] = np.where(start_free, nodes[:, 0], start)
        with np.errstate(all="ignore"):
            theta_w, start_w = _through_windows(problem, coordinates, theta, nodes, start_free)
        if np.all(np.isfinite(theta_w)) and np.all(np.isfinite(start_w)):
            cost_w, states_w = _run(problem, theta_w, start_w)
            if cost_w < cost:
                theta, start, cost, states = theta_w, start_w, cost_w, states_w
    e = sensitivities(problem, theta, coordinates.index, states)
    converged, taken = most_steps == 0, 0
    while taken < most_steps:
        taken += 1
        solved = _solve(e, coordinates, theta, start_free, damping)
        if solved is None or not np.isfinite(cost):
            break
        dz, dx = solved
        share = coordinates.shorten(dz)
        theta_new, start_new = coordinates.move(theta, share * dz), start + share * dx
        cost_new, states_new = _run(problem, theta_new, start_new)
        gain = cost - cost_new
        if gain >= 0.0:
            theta, start, cost, states = theta_new, start_new, cost_new, states_new
            small = gain <= tolerance * max(cost, 1.0)
            damping = max(damping * (0.1 if share == 1.0 else 1.0), 1e-10)
            e = sensitivities(problem, theta, coordinates.index, states)
            if small and damping < 1e-2:
                converged = True
                break
        else:
            damping = max(damping, 1e-6) * 8.0
            if damping > LARGEST_DAMPING or (len(dz) and np.max(np.abs(dz)) < 1e-10):
                converged = True
                break
    if (
        creases
        and _sticks(problem, theta)
        and np.isfinite(cost)
        and 2.0 * cost > MISFIT * problem.batch.readings
        and len(coordinates.index)
    ):
        wide = replace(coordinates, size=np.maximum(coordinates.size, np.abs(theta[coordinates.index])))
        theta_k, start_k, cost_k = across_kinks(problem, wide, theta, start, start_free, cost)
        if cost_k < cost:
            rest = fit(problem, coordinates, theta_k, start=start_k)
            return replace(rest, steps=rest.steps + taken)
    return Fit(problem, coordinates, theta, start, cost, e, converged, taken, damping)
