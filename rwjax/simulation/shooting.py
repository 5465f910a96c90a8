"""Condensed multiple shooting: windows simulated from their own first states, with sensitivities and normal equations."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float, Int

from rwjax.plant.structure import Structure
from rwjax.simulation import machine_code
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT
from rwjax.simulation.program_cache import stored
from rwjax.simulation.solver import Solver
from rwjax.simulation.windows import log_by_log, plant_of_run, side_by_side

COLUMNS = 8
"""Numbers by which XLA's program differentiates come in multiples of this, so that most fits share one."""


class Evaluation(NamedTuple):
    """Residuals of all windows and what a Gauss-Newton step needs. Axes as in `Batch`; `k` numbers, `n` states.

    Attributes:
        residual: Simulated minus measured, in units of noise `(l, w, q, y)` [1].
        local: Its derivatives by the numbers and by the window's first state `(k+n, l, w, q, y)`.
        chain: Change of a window's first state by the numbers and by the log's first state, from linearised continuity
            `(l, w, n, k+n)`.
        shift: Change of a window's first state that closes the gaps between windows `(l, w, n)`.
        H: Matrix of the normal equations of each log, the windows' states eliminated `(l, k+n, k+n)`.
        g: Their gradient `(l, k+n)`.
        defect: End of a window minus start of the next `(l, w, n)`.
    """

    residual: Float[Any, "l w q y"]
    local: Float[Any, "k+n l w q y"]
    chain: Float[Any, "l w n k+n"]
    shift: Float[Any, "l w n"]
    H: Float[Any, "l k+n k+n"]
    g: Float[Any, "l k+n"]
    defect: Float[Any, "l w n"]


def evaluate(
    structure: Structure,
    theta: Float[Any, " t"],
    numbers: Int[Any, " k"],
    nodes: Float[Any, "l w n"],
    batch: Batch,
    *,
    solver: Solver = EXACT,
) -> Evaluation:
    """Residuals and normal equations with every window started from its node (condensed multiple shooting).

    The windows' states are eliminated by linearised continuity. So the step is that of the whole log, while every window is short
    and all of them run side by side. Forward sensitivities, exact to rounding.

    Args:
        structure: What the plant is made of.
        theta: Numbers of all logs `(t,)` [SI].
        numbers: Which entries of `theta` to differentiate by `(k,)`; an index past its end gives a column of zeros.
        nodes: First state of every window `(l, w, n)` [SI].
        batch: The logs.
        solver: What moves the plant through a window.

    Returns:
        Residuals, derivatives and normal equations.

    Source:
        Bock and Plitt (1984), A multiple shooting algorithm for direct solution of optimal control problems.
    """
    if not any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves((theta, nodes, batch))):
        found = _lowered(structure, np.asarray(theta), np.asarray(numbers), np.asarray(nodes), batch, solver)
        if found is not None:
            return found
        fill = -len(numbers) % COLUMNS if len(numbers) else COLUMNS
        numbers = np.concatenate([numbers, np.full(fill, len(theta))]).astype(int)
    return _evaluate(structure, theta, numbers, nodes, batch, solver=solver)


def _lowered(
    structure: Structure, theta: np.ndarray, numbers: np.ndarray, nodes: np.ndarray, batch: Batch, solver: Solver
) -> Evaluation | None:
    """`evaluate` with lowered programs, log by log."""
    found = []
    for log in range(len(nodes)):
        parts = machine_code.sensitivities(structure, theta, numbers, nodes[log], batch, log, solver)
        each = None if parts is None else _of_log(*parts, nodes[log], batch.reading[log], batch.weight[log])
        if each is None:
            return None
        found.append(each)
    return of_logs(found)


@np.errstate(over="ignore", invalid="ignore")
def _of_log(
    y: np.ndarray,
    end: np.ndarray,
    dy: np.ndarray,
    d_end: np.ndarray,
    nodes: np.ndarray,
    reading: np.ndarray,
    weight: np.ndarray,
) -> Evaluation | None:
    """Residuals and normal equations of one log; those of its arguments have no axis of logs, and `dy` is overwritten."""
    W, n = nodes.shape
    columns, k = len(dy), len(dy) - n
    residual = (y - reading) * weight
    local = np.require(dy, requirements="W")  # the largest array of a fit by far: it is not written a second time
    local *= weight
    defect = np.concatenate([end[:-1] - nodes[1:], np.zeros((1, n))])
    steps = np.ascontiguousarray(np.moveaxis(d_end[k:], 0, -1))
    added = np.concatenate([d_end[:k], np.zeros((n, W, n)), defect[None]])
    first = np.concatenate([np.zeros((k, n)), np.eye(n), np.zeros((1, n))])
    carried = machine_code.continued(steps, added, first)
    if carried is None:
        return None
    seen = weight.any(axis=0).any(axis=0)  # outputs; along both axes at once numpy takes ten times as long
    flat = local[..., seen].reshape(columns, W, -1)
    through = np.empty((columns + 1, *flat.shape[1:]))  # the derivatives through the whole run, and the residual
    np.matmul(carried.transpose(1, 0, 2), flat[k:].transpose(1, 0, 2), out=through.transpose(1, 0, 2))
    through[:k] += flat[:k]
    through[-1] += residual[..., seen].reshape(W, -1)
    G = through.reshape(columns + 1, -1)
    normal = G @ G.T
    chain, shift = np.moveaxis(carried[:-1], 0, -1), carried[-1]
    return Evaluation(
        residual[None],
        local[:, None],
        chain[None],
        shift[None],
        normal[None, :-1, :-1],
        normal[None, -1, :-1],
        defect[None],
    )


def of_logs(found: Sequence[Evaluation]) -> Evaluation:
    """Evaluations of some logs each, as one of all of them.

    Args:
        found: The evaluations, at least one.

    Returns:
        The evaluation of their logs in this order.
    """
    if len(found) == 1:
        return found[0]
    axis = {name: 1 if name == "local" else 0 for name in Evaluation._fields}
    return Evaluation(*(np.concatenate([getattr(e, name) for e in found], axis[name]) for name in axis))


@stored(Evaluation._make)
def _evaluate(
    structure: Structure,
    theta: Float[Any, " t"],
    numbers: Int[Any, " k"],
    nodes: Float[Any, "l w n"],
    batch: Batch,
    *,
    solver: Solver = EXACT,
) -> Evaluation:
    """`evaluate` through XLA."""

    def outcome(theta: Float[Array, " t"], nodes: Float[Array, "l w n"]) -> tuple[Array, Array]:
        y, end = _simulate_windows(structure, solver, theta, nodes, batch)
        return (y - jnp.asarray(batch.reading)) * jnp.asarray(batch.weight), end

    k, (L, W, n) = numbers.shape[0], nodes.shape
    by_number = jnp.concatenate([jax.nn.one_hot(numbers, theta.shape[0]), jnp.zeros((n, theta.shape[0]))])
    by_state = jnp.concatenate([jnp.zeros((k, n)), jnp.eye(n)])
    tangents = (by_number, jnp.broadcast_to(by_state[:, None, None], (k + n, L, W, n)))
    (residual, end), (local, d_end) = jax.vmap(lambda d: jax.jvp(outcome, (theta, nodes), d), out_axes=(None, 0))(
        tangents
    )
    d_end = jnp.moveaxis(d_end, 0, -1)
    defect = (end - jnp.concatenate([nodes[:, 1:], end[:, -1:]], axis=1)).at[:, -1].set(0.0)
    chain, shift = _continuity(d_end, defect)
    H, g = _condensed(residual, local, chain, shift)
    return Evaluation(residual, local, chain, shift, H, g, defect)


@stored(lambda found: found[0])
def transitions(
    structure: Structure,
    theta: Float[Any, " t"],
    nodes: Float[Any, "l w n"],
    batch: Batch,
    *,
    solver: Solver = EXACT,
) -> Any:
    """How a change of a window's first state shows at its end.

    Args:
        structure: What the plant is made of.
        theta: Numbers of all logs `(t,)` [SI].
        nodes: First state of every window `(l, w, n)` [SI].
        batch: The logs.
        solver: What moves the plant through a window.

    Returns:
        Derivative of a window's last state by its first one `(l, w, n, n)` [SI/SI].
    """

    def ends(nodes: Float[Array, "l w n"]) -> Array:
        return _simulate_windows(structure, solver, theta, nodes, batch)[1]

    n = nodes.shape[2]
    each = jnp.broadcast_to(jnp.eye(n)[:, None, None], (n, *nodes.shape))
    d_end = jax.vmap(lambda d: jax.jvp(ends, (nodes,), (d,))[1])(each)
    return [jnp.moveaxis(d_end, 0, -1)]


def _simulate_windows(
    structure: Structure, solver: Solver, theta: Float[Array, " t"], nodes: Float[Array, "l w n"], batch: Batch
) -> tuple[Float[Array, "l w q y"], Float[Array, "l w n"]]:
    """Readings of every window from its own first state, and the state at its end."""
    through = log_by_log if jax.default_backend() == "cpu" else side_by_side
    return through(lambda run, nodes: solver.windows(plant_of_run(structure, theta, run), run, nodes), batch, nodes)


def _continuity(
    d_end: Float[Array, "l w n a"], defect: Float[Array, "l w n"]
) -> tuple[Float[Array, "l w n a"], Float[Array, "l w n"]]:
    """`chain` and `shift` of an `Evaluation`, from the derivatives of every window's end."""
    n = d_end.shape[2]
    k = d_end.shape[3] - n

    def link(carry: tuple[Array, Array], window: tuple[Array, Array]) -> tuple[tuple[Array, Array], tuple]:
        chain, shift = carry
        d_end, defect = window
        by_theta = jnp.concatenate([d_end[:, :k], jnp.zeros((n, n))], axis=1)
        return (d_end[:, k:] @ chain + by_theta, d_end[:, k:] @ shift + defect), (chain, shift)

    first = (jnp.concatenate([jnp.zeros((n, k)), jnp.eye(n)], axis=1), jnp.zeros(n))
    return jax.vmap(lambda d, e: jax.lax.scan(link, first, (d, e))[1])(d_end, defect)


def _condensed(
    residual: Float[Array, "l w q y"],
    local: Float[Array, "a l w q y"],
    chain: Float[Array, "l w n a"],
    shift: Float[Array, "l w n"],
) -> tuple[Float[Array, "l a a"], Float[Array, "l a"]]:
    """Normal equations of each log, the windows' states eliminated."""
    L, W, n, size = chain.shape
    k = size - n
    H_local = jnp.einsum("alwqy,blwqy->lwab", local, local)
    g_local = jnp.einsum("alwqy,lwqy->lwa", local, residual)
    upper = jnp.broadcast_to(jnp.eye(k + n)[:k], (L, W, k, k + n))
    C = jnp.concatenate([upper, chain], axis=2)
    c = jnp.concatenate([jnp.zeros((L, W, k)), shift], axis=2)
    H = jnp.einsum("lwai,lwab,lwbj->lij", C, H_local, C, optimize="optimal")
    g = jnp.einsum("lwai,lwa->li", C, g_local + jnp.einsum("lwab,lwb->lwa", H_local, c))
    return H, g
