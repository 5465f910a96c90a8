"""Gauss-Newton steps whose initial states follow the numbers, log by log."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import residual_jacobian
from rwjax.simulation.shooting import Evaluation

LARGEST_DAMPING = 1e8
"""Levenberg-Marquardt damping above which no step gains anything [1]."""


@np.errstate(over="ignore", invalid="ignore")  # a run that leaves the range of numbers: its step is refused
def initial_state_normal(problem: Problem, e: Evaluation, log: int) -> tuple[np.ndarray, np.ndarray]:
    """Normal equations of the readings from which a log's initial state is estimated.

    Those are the readings of its first 0.5 s where its initial state is estimated from its start, else all.

    Args:
        problem: Logs and structure.
        e: Derivatives at the present point.
        log: Number of the log.

    Returns:
        Normal matrix `(k+n, k+n)` [1/SI²] and gradient `(k+n,)` [1/SI].
    """
    if not problem.initial_state_from_start[log]:
        return e.H[log], e.g[log]
    first = problem.start_only.batch
    windows = first.windows
    counts = (first.weight[log] > 0.0)[..., None]
    G = np.where(counts, residual_jacobian(e, log, windows=windows), 0.0).reshape(-1, len(e.local))
    return G.T @ G, G.T @ np.where(counts[..., 0], e.residual[log, :windows], 0.0).ravel()


def initial_state_response(
    H: np.ndarray, g: np.ndarray, k: np.ndarray, s: np.ndarray, damping: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Change of an initial state that minimises the cost, per change of the numbers and by itself.

    Args:
        H: Normal matrix of `initial_state_normal` `(k+n, k+n)` [1/SI²].
        g: Gradient `(k+n,)` [1/SI].
        k: Rows of the numbers `(k,)` [index].
        s: Rows of the unknown entries of the initial state `(s,)` [index].
        damping: Levenberg-Marquardt damping [1], or several `(d,)`.

    Returns:
        Change per change of the numbers `(s, k)`, and at fixed numbers `(s,)` [SI], of several dampings `(d, s, k)` and `(d, s)`;
        NaN where the normal matrix is not finite.
    """
    shape, Hss = np.shape(damping), H[s[:, None], s]
    if not np.isfinite(Hss).all():  # a run that leaves the range of numbers: the step is refused where it is taken
        return np.full((*shape, len(s), len(k)), np.nan), np.full((*shape, len(s)), np.nan)
    diagonal = np.diag(Hss)
    if not np.any(diagonal):  # no reading depends on these entries: they stay
        return np.zeros((*shape, len(s), len(k))), np.zeros((*shape, len(s)))
    ridge = np.multiply.outer(damping, diagonal) + 1e-12 * max(np.max(diagonal, initial=0.0), 1e-300)
    by_both = np.column_stack([H[s[:, None], k], g[s]])
    found = -np.linalg.solve(Hss + ridge[..., None] * np.eye(len(s)), by_both)
    return found[..., :-1], found[..., -1]


def changes_of_numbers(problem: Problem, e: Evaluation, log: int, k: int) -> np.ndarray:
    """Changes of a log's numbers, each with the change of the initial state that follows from it.

    Args:
        problem: Logs and structure.
        e: Derivatives at the present point.
        log: Number of the log.
        k: How many numbers [1].

    Returns:
        Changes of the numbers and of the initial state `(k+n, k)` [SI], one in each column, as `residual_jacobian` takes them.
    """
    s = len(e.local) - problem.start.shape[1] + np.flatnonzero(problem.start_free[log])
    along = np.eye(len(e.local), k)
    along[s] = initial_state_response(*initial_state_normal(problem, e, log), np.arange(k), s, 0.0)[0]
    return along


class _Reduced(NamedTuple):
    """Normal equations of the coordinates with the initial states eliminated.

    `A` (k, k), `b` (k,); `responses`: for each log the unknown entries of its initial state, their change per change of
    the coordinates, and by itself.
    """

    A: np.ndarray
    b: np.ndarray
    responses: list[tuple[np.ndarray, np.ndarray, np.ndarray]]


def _reduced(
    problem: Problem, e: Evaluation, coordinates: Coordinates, theta: np.ndarray, dampings: Sequence[float]
) -> list[_Reduced]:
    """The normal equations at a point with each of several dampings."""
    free, scale, every = coordinates.index, coordinates.slope(theta), np.array(dampings)
    A = np.tile(np.diag(problem.precision[free] * scale**2), (len(every), 1, 1))
    b = np.tile(problem.prior_cost(theta)[1][free] * scale, (len(every), 1))
    responses = []
    for log in range(len(problem.start)):
        of_log = _reduced_of_log(problem, e, scale, log, every)
        A += of_log.A
        b += of_log.b
        responses.append(of_log.response)
    return [_Reduced(A[d], b[d], [(s, P[d], q[d]) for s, P, q in responses]) for d in range(len(every))]


class _ReducedOfLog(NamedTuple):
    """What a log adds to the reduced normal equations with each of several dampings: `A` (d, k, k), `b` (d, k), and its `_Reduced.responses`."""

    A: np.ndarray
    b: np.ndarray
    response: tuple[np.ndarray, np.ndarray, np.ndarray]


def _reduced_of_log(problem: Problem, e: Evaluation, scale: np.ndarray, log: int, every: np.ndarray) -> _ReducedOfLog:
    """The share of a log in the reduced normal equations."""
    k, s, p = np.arange(len(scale)), np.flatnonzero(problem.start_free[log]), e.g.shape[1] - problem.start.shape[1]
    H, g = e.H[log], e.g[log]
    P, q = initial_state_response(*initial_state_normal(problem, e, log), k, p + s, every)
    P, transposed = P * scale, np.swapaxes(P * scale, 1, 2)
    Hts, Hss = H[k[:, None], p + s] * scale[:, None], H[(p + s)[:, None], p + s]
    across = Hts @ P
    A = H[k[:, None], k] * scale[:, None] * scale + across + np.swapaxes(across, 1, 2) + transposed @ Hss @ P
    A[:, k, k] += np.multiply.outer(every, H[k, k] * scale**2)
    b = g[k] * scale + transposed @ g[p + s] + ((Hts + transposed @ Hss) @ q[..., None])[..., 0]
    return _ReducedOfLog(A, b, (s, P, q))


def _within_bounds(A: np.ndarray, b: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Solution `(k,)` of `A dz = -b` in which no coordinate at a bound (`low`, `high`) leaves through it."""
    held = np.diag(A) <= 0.0  # no reading depends on these
    dz = np.zeros(len(b))
    for _ in range(len(b) + 1):
        move = np.flatnonzero(~held)
        dz = np.zeros(len(b))
        if len(move):
            M = A[np.ix_(move, move)]
            d = np.sqrt(np.maximum(np.diag(M), 1e-300))
            dz[move] = -np.linalg.lstsq(M / d / d[:, None], b[move] / d, rcond=1e-13)[0] / d
        leaving = ~held & ((low & (dz < 0.0)) | (high & (dz > 0.0)))
        if not leaving.any():
            break
        held |= leaving
    return dz


@np.errstate(over="ignore", invalid="ignore")
def gauss_newton_steps(
    problem: Problem, e: Evaluation, coordinates: Coordinates, theta: np.ndarray, dampings: Sequence[float]
) -> list[tuple[np.ndarray, np.ndarray] | None]:
    """Damped Gauss-Newton steps of the coordinates and of each log's initial state.

    Initial states follow the numbers by `initial_state_response`. A number on a bound is held where the step would
    leave through it.

    Args:
        problem: Logs and structure.
        e: Derivatives at `theta`.
        coordinates: The free numbers.
        theta: Parameter vector `(t,)` [SI].
        dampings: Levenberg-Marquardt dampings [1].

    Returns:
        For each damping the change of the coordinates `(k,)` [1] and of the initial states `(l, n)` [SI]; None where the
        derivatives are not finite.
    """
    bounds = coordinates.on_bound(theta)
    return [_step(problem, reduced, *bounds) for reduced in _reduced(problem, e, coordinates, theta, dampings)]


@np.errstate(over="ignore", invalid="ignore")
def steps_without(
    problem: Problem,
    e: Evaluation,
    coordinates: Coordinates,
    theta: np.ndarray,
    left_out: Sequence[Sequence[int]],
    most: float,
) -> list[np.ndarray | None]:
    """Gauss-Newton steps that some logs' absence asks for, each from the same point: what a fit without them moves by, to first order.

    Args:
        problem: Logs and structure.
        e: Derivatives at `theta`.
        coordinates: The free numbers.
        theta: Parameter vector `(t,)` [SI].
        left_out: Numbers of the logs that are left out together, for each step.
        most: Share of what all logs tell, along any direction of the coordinates, up to which the left out ones may tell it [1].

    Returns:
        For each the change of the coordinates `(k,)` [1]; None where the left out logs tell more than that, or derivatives are not finite.
    """
    low, high = coordinates.on_bound(theta)
    whole = _reduced(problem, e, coordinates, theta, [0.0])[0]
    scale, steps = coordinates.slope(theta), []
    for logs in left_out:
        parts = [_reduced_of_log(problem, e, scale, log, np.zeros(1)) for log in logs]
        lost, b = np.sum([part.A[0] for part in parts], axis=0), whole.b - np.sum([part.b[0] for part in parts], axis=0)
        light = np.all(np.isfinite(whole.A)) and np.all(np.isfinite(b)) and _largest_share(whole.A, lost) <= most
        steps.append(_within_bounds(whole.A - lost, b, low, high) if light else None)
    return steps


def _largest_share(whole: np.ndarray, part: np.ndarray) -> float:
    """Largest share [1] of a matrix of normal equations that a part of it has along any direction which the whole one tells.

    It is infinite where derivatives ran away so far that rounding leaves squares below 0.
    """
    if np.any(np.diag(whole) < 0.0):
        return np.inf
    read = np.ix_(*[np.flatnonzero(np.diag(whole) > 0.0)] * 2)
    whole, part = whole[read], part[read]
    scale = np.sqrt(np.diag(whole))
    size, along = np.linalg.eigh(whole / scale / scale[:, None])
    told = size > 1e-12 * np.max(size, initial=0.0)
    along = along[:, told] / np.sqrt(size[told])
    shares = np.linalg.eigvalsh(along.T @ (part / scale / scale[:, None]) @ along)
    return float(np.max(shares, initial=0.0))


def gauss_newton_step(
    problem: Problem, e: Evaluation, coordinates: Coordinates, theta: np.ndarray, damping: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """The step of `gauss_newton_steps` with one damping.

    Args:
        problem: Logs and structure.
        e: Derivatives at `theta`.
        coordinates: The free numbers.
        theta: Parameter vector `(t,)` [SI].
        damping: Levenberg-Marquardt damping [1].

    Returns:
        Change of the coordinates `(k,)` [1] and of the initial states `(l, n)` [SI]; None where the derivatives are not
        finite.
    """
    return gauss_newton_steps(problem, e, coordinates, theta, [damping])[0]


def _step(
    problem: Problem, reduced: _Reduced, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    A, b, responses = reduced
    if not (np.all(np.isfinite(A)) and np.all(np.isfinite(b))):
        return None
    dz = _within_bounds(A, b, low, high)
    dx = np.zeros(problem.start.shape)
    for log, (s, P, q) in enumerate(responses):
        dx[log, s] = q + P @ dz
    return dz, dx
