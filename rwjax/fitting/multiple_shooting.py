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

from rwjax.fitting.batched_runs import on_threads
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.nonsmooth import across_kinks
from rwjax.fitting.problem import Problem
from rwjax.simulation.batch import Batch
from rwjax.simulation.shooting import Evaluation, evaluate, free_run

WINDOW_STEPS = 8
COLUMNS = 8
"""Numbers differentiated by come in multiples of this, so that most fits share one compiled program."""
LONG = 4000
"""Steps of a log from which a call of its own costs less than it saves."""
LARGEST_DAMPING = 1e8
LIGHT = 1e-9
"""Damping below which a fit with a prior may end: a prior is light against readings, and heavy damping hides it."""
START_STEPS = 12
MISFIT = 1.5
"""Mean square in units of noise above which creases of the sum of squares may have stopped a fit early."""


@dataclass(frozen=True)
class Fit:
    """Result of a fit. `theta` all numbers in the order of `problem.names`, `start` first state of each log.

    `cost`: half the sum of squared residuals in units of noise. `evaluation`: sensitivities at the optimum, windows
    started from the free run (numpy arrays). `converged`: False where the step limit came first or no
    step could be solved for.
    """

    problem: Problem
    coordinates: Coordinates
    theta: np.ndarray
    start: np.ndarray
    cost: float
    evaluation: Evaluation
    converged: bool
    steps: int

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free numbers."""
        return tuple(self.problem.names[k] for k in self.coordinates.index)

    def numbers(self) -> dict[str, float]:
        """All numbers by name."""
        return dict(zip(self.problem.names, (float(v) for v in self.theta), strict=True))


def sensitivities(problem: Problem, theta: np.ndarray, numbers: np.ndarray, nodes: np.ndarray) -> Evaluation:
    """`evaluate` with its columns by the numbers first, zeros up to a multiple of `COLUMNS`, the states last.

    Of several long logs each has a call and a thread of its own; those without readings in the residual are left at 0.
    """
    padded = np.full(max(-(-len(numbers) // COLUMNS), 1) * COLUMNS, len(theta))
    padded[: len(numbers)] = numbers

    def of(nodes: np.ndarray, batch: Batch) -> Evaluation:
        return Evaluation(*(np.asarray(a) for a in evaluate(problem.structure, theta, padded, nodes, batch)))

    batch, told = problem.batch, problem.told.tolist()
    if len(nodes) == 1 or not told or batch.windows * len(batch.step_index) < LONG:
        return of(nodes, batch)
    found = dict(zip(told, on_threads(lambda log: of(nodes[log : log + 1], batch.of(log)), told), strict=True))
    nothing = Evaluation(*(np.zeros_like(a) for a in found[told[0]]))
    every = [found.get(log, nothing) for log in range(len(nodes))]
    axis = {name: 1 if name == "local" else 0 for name in Evaluation._fields}  # of logs
    return Evaluation(*(np.concatenate([getattr(e, name) for e in every], axis[name]) for name in axis))


def _run_each(problem: Problem, theta: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half the sum of squares of each log's free run `(l,)`, and the states at the windows' starts."""
    y, nodes = free_run(problem.structure, theta, start, problem.batch)
    with np.errstate(over="ignore", invalid="ignore"):
        residual = (np.asarray(y) - problem.batch.reading) * problem.batch.weight
        cost = 0.5 * np.sum(residual**2, axis=(1, 2, 3))
    return np.where(np.isfinite(cost), cost, np.inf), np.asarray(nodes)


def _run(problem: Problem, theta: np.ndarray, start: np.ndarray) -> tuple[float, np.ndarray]:
    """Half the sum of squares of all free runs and of the prior, and the states at the windows' starts."""
    cost, nodes = _run_each(problem, theta, start)
    return float(np.sum(cost)) + problem.against_prior(theta)[0], nodes


def reaches_noise(cost: float, theta: np.ndarray, problem: Problem) -> bool:
    """Whether a cost, the prior's share left out, is so low that creases of the sum of squares, or a bad start, cannot
    have stopped the fit early."""
    return 2.0 * (cost - problem.against_prior(theta)[0]) <= MISFIT * problem.batch.readings


def _sticks(problem: Problem, theta: np.ndarray) -> bool:
    """Whether any dry friction acts: without it the sum of squares has no creases."""
    dry = ("friction.coulomb", "friction.static", "friction.b3", ".M_c", ".M_e")
    return any(
        name.partition(" ")[0].endswith(dry) and value > 0.0 for name, value in zip(problem.names, theta, strict=True)
    )


def first_states(problem: Problem, theta: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """First state of each log `(l, n)` by the start rule: least squares over its first 0.5 s, every log for itself."""
    x = problem.start if start is None else start
    early = problem.early
    told = early.batch.weight.any(axis=(1, 2, 3)) & problem.start_free.any(axis=1)
    if not told.any():
        return x
    nothing = np.zeros(0, int)
    cost, nodes = _run_each(early, theta, x)
    damping = np.full(len(x), 1e-3)
    settled = ~told
    for _ in range(START_STEPS):
        e = sensitivities(early, theta, nothing, nodes)
        p = e.g.shape[1] - x.shape[1]
        trial = x.copy()
        for log in np.flatnonzero(~settled & np.isfinite(e.g).all(axis=1)):
            s = np.flatnonzero(problem.start_free[log])
            trial[log, s] += start_response(e.H[log], e.g[log], nothing, p + s, damping[log])[1]
        cost_new, nodes_new = _run_each(early, theta, trial)
        better = np.isfinite(cost_new) & (cost_new <= cost)
        gain = np.where(better, cost, 0.0) - np.where(better, cost_new, 0.0)  # of runs that leave the range: none
        settled |= better & (gain <= 1e-5 * np.maximum(cost, 1.0))
        damping = np.where(better, np.maximum(0.1 * damping, 1e-10), 8.0 * np.maximum(damping, 1e-6))
        settled |= damping > LARGEST_DAMPING
        x, cost = np.where(better[:, None], trial, x), np.where(better, cost_new, cost)
        nodes = np.where(better[:, None, None], nodes_new, nodes)
        if settled.all():
            break
    return x


def _project(problem: Problem, theta: np.ndarray, start: np.ndarray) -> np.ndarray:
    """First states with those of logs whose first state follows from their start set by the start rule."""
    if not problem.initial_state_from_start.any():
        return start
    initial_state_from_start = replace(
        problem, start_free=problem.start_free & problem.initial_state_from_start[:, None]
    )
    return np.where(
        problem.initial_state_from_start[:, None], first_states(initial_state_from_start, theta, start), start
    )


def by_start(e: Evaluation, log: int) -> np.ndarray:
    """Derivative of a log's residual by (numbers, first state) through the whole run `(w, q, y, k+n)`."""
    windows, n = e.residual.shape[1], e.chain.shape[2]
    return _through(e.local[:, log], e.chain[log], windows, len(e.local) - n)


def _through(local: np.ndarray, chain: np.ndarray, windows: int, p: int) -> np.ndarray:
    through = np.einsum("nwqy,wnc->wqyc", local[p:, :windows], chain[:windows])
    through[..., :p] += np.moveaxis(local[:p, :windows], 0, -1)
    return through


@np.errstate(over="ignore", invalid="ignore")  # a run that leaves the range of numbers: its step is refused
def start_normal(problem: Problem, e: Evaluation, log: int) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix and gradient `(k+n, k+n)`, `(k+n,)` of the readings that tell a log's first state: those of its
    first 0.5 s where its first state follows from its start, else all."""
    if not problem.initial_state_from_start[log]:
        return e.H[log], e.g[log]
    first = problem.early.batch
    windows = first.windows
    p = len(e.local) - e.chain.shape[2]
    counts = (first.weight[log] > 0.0)[..., None]
    G = np.where(counts, _through(e.local[:, log], e.chain[log], windows, p), 0.0).reshape(-1, len(e.local))
    return G.T @ G, G.T @ np.where(counts[..., 0], e.residual[log, :windows], 0.0).ravel()


def start_response(H: np.ndarray, g: np.ndarray, k: np.ndarray, s: np.ndarray, damping: float):
    """Change of the first state's entries `s` per change of the numbers `k`, and by itself, that `start_normal` asks."""
    Hss = H[np.ix_(s, s)]
    diagonal = np.diag(Hss)
    if not np.any(diagonal):  # no reading tells these entries: they stay
        return np.zeros((len(s), len(k))), np.zeros(len(s))
    ridge = damping * diagonal + 1e-12 * max(np.max(diagonal, initial=0.0), 1e-300)
    with np.errstate(all="ignore"):  # a run that leaves the range of numbers: the step is refused where it is taken
        inverse = np.linalg.pinv(Hss + np.diag(ridge), hermitian=True) if len(s) else np.zeros((0, 0))
        return -inverse @ H[np.ix_(s, k)], -inverse @ g[s]


@np.errstate(over="ignore", invalid="ignore")
def step_of(
    problem: Problem, e: Evaluation, coordinates: Coordinates, theta: np.ndarray, damping: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """Damped Gauss-Newton step: change of the coordinates, and of each log's first state.

    First states follow the numbers as `start_response` says, log by log; numbers on a bound that the step would leave
    through are held.
    """
    k = np.arange(len(coordinates.index))
    scale = coordinates.slope(theta)
    L, n = problem.start.shape
    p = e.g.shape[1] - n
    free = coordinates.index
    A, parts = np.diag(problem.precision[free] * scale**2), []
    b = problem.against_prior(theta)[1][free] * scale
    for log in range(L):
        s = np.flatnonzero(problem.start_free[log])
        P, q = start_response(*start_normal(problem, e, log), k, p + s, damping)
        P = P * scale
        H, g = e.H[log], e.g[log]
        Hts, Hss = H[np.ix_(k, p + s)] * scale[:, None], H[np.ix_(p + s, p + s)]
        reduced = H[np.ix_(k, k)] * scale[:, None] * scale + Hts @ P + P.T @ Hts.T + P.T @ Hss @ P
        A += reduced
        A[np.diag_indices(len(k))] += damping * H[k, k] * scale**2
        b += g[k] * scale + P.T @ g[p + s] + (Hts + P.T @ Hss) @ q
        parts.append((s, P, q))
    if not (np.all(np.isfinite(A)) and np.all(np.isfinite(b))):
        return None
    held = np.diag(A) <= 0.0  # no reading tells these
    low, high = coordinates.on_bound(theta)
    dz = np.zeros(len(k))
    for _ in range(len(k) + 1):
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
    for log, (s, P, q) in enumerate(parts):
        dx[log, s] = q + P @ dz
    return dz, dx


def _through_windows(
    problem: Problem, c: Coordinates, theta: np.ndarray, nodes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """First phase: a few steps from states read off the log. Returns numbers and first states."""
    damping = 1e-3
    for _ in range(WINDOW_STEPS):
        e = sensitivities(problem, theta, c.index, nodes)
        step = step_of(problem, e, c, theta, damping)
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
    """Least squares of the free run over the free numbers and the logs' first states, those of logs whose first state follows from their start by the
    start rule at every step.

    With `nodes` (l, w, n) given, the short windows come first and the better of both starts is kept. With `creases`, a
    fit that ends well above the noise goes on by steps across the creases of stick and slip.
    """
    theta = coordinates.inward(theta)
    start = _project(problem, theta, problem.start if start is None else start)
    cost, states = _run(problem, theta, start)
    if nodes is not None:
        nodes = nodes.copy()
        nodes[:, 0] = np.where(problem.start_free, nodes[:, 0], start)
        with np.errstate(all="ignore"):
            theta_w, start_w = _through_windows(problem, coordinates, theta, nodes)
        if np.all(np.isfinite(theta_w)) and np.all(np.isfinite(start_w)):
            start_w = _project(problem, theta_w, start_w)
            cost_w, states_w = _run(problem, theta_w, start_w)
            if cost_w < cost:
                theta, start, cost, states = theta_w, start_w, cost_w, states_w
    e = sensitivities(problem, theta, coordinates.index, states)
    converged, taken = most_steps == 0, 0
    while taken < most_steps:
        taken += 1
        solved = step_of(problem, e, coordinates, theta, damping)
        if solved is None or not np.isfinite(cost):
            break
        dz, dx = solved
        share = coordinates.shorten(dz)
        theta_new = coordinates.move(theta, share * dz)
        start_new = _project(problem, theta_new, start + share * dx)
        cost_new, states_new = _run(problem, theta_new, start_new)
        gain = cost - cost_new
        if gain >= 0.0:
            theta, start, cost, states = theta_new, start_new, cost_new, states_new
            small = gain <= tolerance * max(cost, 1.0)
            damping = max(damping * (0.1 if share == 1.0 else 1.0), 1e-10)
            e = sensitivities(problem, theta, coordinates.index, states)
            if small and damping < (LIGHT if problem.precision.any() else 1e-2):
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
        and not reaches_noise(cost, theta, problem)
        and len(coordinates.index)
    ):
        wide = replace(coordinates, size=np.maximum(coordinates.size, np.abs(theta[coordinates.index])))
        free = problem.start_free & ~problem.initial_state_from_start[:, None]
        theta_k, start_k, _ = across_kinks(problem, wide, theta, start, free, cost)
        rest = fit(problem, coordinates, theta_k, start=start_k)
        if rest.cost < cost:
            return replace(rest, steps=rest.steps + taken)
    return Fit(problem, coordinates, theta, start, cost, e, converged, taken)
