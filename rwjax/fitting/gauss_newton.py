"""TODO."""

import numpy as np

from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import chained
from rwjax.simulation.shooting import Evaluation


@np.errstate(over="ignore", invalid="ignore")
def gauss_newton_step(
    problem: Problem, e: Evaluation, coordinates: Coordinates, theta: np.ndarray, damping: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """Damped Gauss-Newton step: change of the coordinates, and of each log's first state.

    First states follow the numbers as `initial_state_response` says, log by log; numbers on a bound that the step would leave
    through are held.
    """
    k = np.arange(len(coordinates.index))
    scale = coordinates.slope(theta)
    L, n = problem.start.shape
    p = e.g.shape[1] - n
    free = coordinates.index
    A, parts = np.diag(problem.precision[free] * scale**2), []
    b = problem.prior_cost(theta)[1][free] * scale
    for log in range(L):
        s = np.flatnonzero(problem.start_free[log])
        P, q = initial_state_response(*initial_state_normal(problem, e, log), k, p + s, damping)
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


@np.errstate(over="ignore", invalid="ignore")  # a run that leaves the range of numbers: its step is refused
def initial_state_normal(problem: Problem, e: Evaluation, log: int) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix and gradient `(k+n, k+n)`, `(k+n,)` of the readings that tell a log's first state: those of its
    first 0.5 s where its first state follows from its start, else all."""
    if not problem.initial_state_from_start[log]:
        return e.H[log], e.g[log]
    first = problem.start_only.batch
    windows = first.windows
    p = len(e.local) - e.chain.shape[2]
    counts = (first.weight[log] > 0.0)[..., None]
    G = np.where(counts, chained(e.local[:, log], e.chain[log], windows, p), 0.0).reshape(-1, len(e.local))
    return G.T @ G, G.T @ np.where(counts[..., 0], e.residual[log, :windows], 0.0).ravel()


def initial_state_response(H: np.ndarray, g: np.ndarray, k: np.ndarray, s: np.ndarray, damping: float):
    """Change of the first state's entries `s` per change of the numbers `k`, and by itself, that `initial_state_normal` asks."""
    Hss = H[np.ix_(s, s)]
    diagonal = np.diag(Hss)
    if not np.any(diagonal):  # no reading tells these entries: they stay
        return np.zeros((len(s), len(k))), np.zeros(len(s))
    ridge = damping * diagonal + 1e-12 * max(np.max(diagonal, initial=0.0), 1e-300)
    with np.errstate(all="ignore"):  # a run that leaves the range of numbers: the step is refused where it is taken
        inverse = np.linalg.pinv(Hss + np.diag(ridge), hermitian=True) if len(s) else np.zeros((0, 0))
        return -inverse @ H[np.ix_(s, k)], -inverse @ g[s]


LARGEST_DAMPING = 1e8
