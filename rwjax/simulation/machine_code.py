"""Which programs of the simulation are lowered, one log at a time, and what lies in their lanes.

Free runs of one log: the lanes are runs with numbers and first states of their own. Windows of one log with derivatives: the lanes are
windows. Continuity of the windows: the lanes are columns of the derivative. Each function gives None where its program runs through
XLA instead.
"""

from collections.abc import Callable
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from rwjax.lowering.arrays import FEW, Spread
from rwjax.lowering.kept import lowered
from rwjax.lowering.program import Lowered
from rwjax.plant.structure import Structure
from rwjax.simulation.batch import WITHOUT_LOG_AXIS, Batch
from rwjax.simulation.solver import Solver
from rwjax.simulation.windows import plant_of_run

SAME, OF_LANE, OF_DIRECTION = Spread(), Spread(lanes=True), Spread(directions=True)
READ = ("slot_sample", "reading", "weight", "share")
"""Entries of a batch that no simulation needs."""


def _leaves(batch: Batch, log: int) -> tuple[list[np.ndarray], Callable[[list], Batch]]:
    """What a simulation needs of a log, and what makes one log of a batch of it."""
    names = [name for name in batch._fields if name not in READ]
    every = (getattr(batch, name) for name in names)
    held = [np.asarray(a if name in WITHOUT_LOG_AXIS else a[log]) for name, a in zip(names, every, strict=True)]
    absent = dict.fromkeys(READ, batch.h)
    return held, lambda values: Batch(**dict(zip(names, values, strict=True)), **absent)


def _program(
    name: str,
    structure: Structure,
    solver: Solver,
    function: Callable,
    arguments: list[np.ndarray],
    given: list[Spread],
) -> Lowered | None:
    """A program of a plant and a solver; none for a solver with numbers of its own."""
    if jax.tree.leaves(solver):
        return None
    keep = structure.from_library and solver.from_library
    return lowered(name, (structure, solver), function, arguments, given, keep)


def runs(
    structure: Structure, theta: np.ndarray, start: np.ndarray, windows: int, batch: Batch, solver: Solver
) -> tuple[np.ndarray, np.ndarray] | None:
    """First windows of free runs of one log, each with numbers and a first state of its own.

    Args:
        structure: What the plant is made of.
        theta: Numbers `(b, t)` for each run [SI].
        start: First states `(b, n)` [SI].
        windows: How many windows to simulate [1].
        batch: The log.
        solver: What moves the plant through it.

    Returns:
        Readings `(b, w, q, y)` [rad, rad/s or A] and states at the windows' starts `(b, w, n)` [SI]; those of later windows do not count.
    """
    held, run_of = _leaves(batch, 0)

    def function(theta: Array, start: Array, windows: Array, *values: Array) -> Any:
        run = run_of(list(values))
        return solver.beginning(plant_of_run(structure, theta, run), run, start, windows)

    shared = [np.array(windows), *held]
    given = [OF_LANE, OF_LANE, *[SAME] * len(shared)]
    program = _program("runs", structure, solver, function, [theta[0], start[0], *shared], given)
    if program is None:
        return None
    y, nodes = program([theta, start, *shared], rows=len(theta))
    return y, nodes


def sensitivities(
    structure: Structure,
    theta: np.ndarray,
    numbers: np.ndarray,
    nodes: np.ndarray,
    batch: Batch,
    log: int,
    solver: Solver,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """Windows of one log, each from a first state of its own, with derivatives by numbers and by these states.

    Args:
        structure: What the plant is made of.
        theta: Numbers of all logs `(t,)` [SI].
        numbers: Which entries of `theta` to differentiate by `(k,)` [index]; one past its end gives zeros.
        nodes: First state of every window `(w, n)` [SI].
        batch: The logs.
        log: Number of the log.
        solver: What moves the plant through a window.

    Returns:
        Readings `(w, q, y)` [rad, rad/s or A], states at the windows' ends `(w, n)` [SI], and the derivatives of both by the numbers
        and by the first state `(k+n, w, q, y)` and `(k+n, w, n)`.
    """
    held, run_of = _leaves(batch, log)
    (W, n), k = nodes.shape, len(numbers)

    def one(theta: Array, node: Array, w: Array, run: Batch) -> tuple[Array, Array]:
        window, inputs = solver.through_windows(plant_of_run(structure, theta, run), run)
        end, y = window(node, jax.tree.map(lambda a: jax.lax.dynamic_index_in_dim(a, w, keepdims=False), inputs))
        return y, end

    def function(theta: Array, node: Array, w: Array, d_theta: Array, d_node: Array, *values: Array) -> Any:
        run = run_of(list(values))
        found, moved = jax.jvp(lambda a, b: one(a, b, w, run), (theta, node), (d_theta, d_node))
        return (*found, *moved)

    d_theta = np.concatenate([np.arange(len(theta)) == numbers[:, None], np.zeros((n, len(theta)))]).astype(float)
    d_node = np.concatenate([np.zeros((k, n)), np.eye(n)])
    each = [theta, nodes[0], np.array(0), d_theta[0], d_node[0], *held]
    given = [SAME, OF_LANE, OF_LANE, OF_DIRECTION, OF_DIRECTION, *[SAME] * len(held)]
    program = _program("sensitivities", structure, solver, function, each, given)
    if program is None:
        return None
    y, end, dy, d_end = program([theta, nodes, np.arange(W), d_theta, d_node, *held], rows=W, directions=k + n)
    return y, end, dy, d_end


def continued(steps: np.ndarray, added: np.ndarray, first: np.ndarray) -> np.ndarray | None:
    r"""Columns carried from window to window: $c_{w+1} = A_w c_w + b_w$.

    Args:
        steps: The matrices $A_w$ `(w, n, n)` [any unit].
        added: What is added, for each column `(a, w, n)` [any unit].
        first: Each column before the first window `(a, n)` [any unit].

    Returns:
        The columns before each window `(a, w, n)` [any unit].
    """

    def function(steps: Float[Array, "w n n"], added: Float[Array, "w n"], first: Float[Array, " n"]) -> Array:
        def link(c: Array, window: tuple[Array, Array]) -> tuple[Array, Array]:
            return window[0] @ c + window[1], c

        return jax.lax.scan(link, first, (steps, added))[1]

    if len(steps[0]) > FEW:
        carried = np.empty(added.shape)
        for w, step in enumerate(steps):
            carried[:, w] = first
            first = first @ step.T + added[:, w]
        return carried
    program = lowered("continued", None, function, [steps, added[0], first[0]], [SAME, OF_LANE, OF_LANE], keep=True)
    return None if program is None else program([steps, added, first], rows=len(added))[0]
