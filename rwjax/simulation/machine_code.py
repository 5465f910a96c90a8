"""Which programs of the simulation are lowered, and what lies in their lanes.

Free runs: the lanes are runs, each of a log of its own with numbers and a first state of its own. Windows of one log with derivatives: the
lanes are windows. Continuity of the windows: the lanes are columns of the derivative. Each function gives None where its program runs
through XLA instead.
"""

from collections.abc import Callable, Sequence
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
OF_NO_RUN = (*WITHOUT_LOG_AXIS, "theta_index", "theta_offset")
"""Entries that are the same for all runs whose numbers are given as their plants have them."""


def _inputs(batch: Batch) -> tuple[dict[str, np.ndarray], Callable[[Sequence], Batch]]:
    """What a simulation needs of a batch, by name, and what makes one log of a batch of its values."""
    needed = {name: np.asarray(a) for name, a in batch._asdict().items() if name not in READ}
    absent = dict.fromkeys(READ, batch.h)
    return needed, lambda values: Batch(**dict(zip(needed, values, strict=True)), **absent)


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
    """First windows of free runs, each of a log of its own with numbers and a first state of its own.

    Args:
        structure: What the plant is made of.
        theta: Numbers `(b, p)` of each run's plant [SI].
        start: First states `(b, n)` [SI].
        windows: How many windows to simulate [1].
        batch: The log of each run `(b)`, with numbers as its plant has them.
        solver: What moves the plant through it.

    Returns:
        Readings `(b, w, q, y)` [rad, rad/s or A] and states at the windows' starts `(b, w, n)` [SI]; those of later windows do not count.
    """
    needed, run_of = _inputs(batch)
    held = [a[0] if name in ("theta_index", "theta_offset") else a for name, a in needed.items()]

    def function(theta: Array, start: Array, windows: Array, *values: Array) -> Any:
        run = run_of(values)
        return solver.beginning(plant_of_run(structure, theta, run), run, start, windows)

    same = [name in OF_NO_RUN for name in needed]
    one = [a if alike else np.asarray(a[0]) for a, alike in zip(held, same, strict=True)]
    given = [OF_LANE, OF_LANE, SAME, *(SAME if alike else OF_LANE for alike in same)]
    program = _program("runs", structure, solver, function, [theta[0], start[0], np.array(windows), *one], given)
    if program is None:
        return None
    y, nodes = program([theta, start, np.array(windows), *held], rows=len(theta))
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
    needed, run_of = _inputs(batch)
    held = [a if name in WITHOUT_LOG_AXIS else np.asarray(a[log]) for name, a in needed.items()]
    (W, n), k = nodes.shape, len(numbers)

    def one(theta: Array, node: Array, w: Array, run: Batch) -> tuple[Array, Array]:
        window, inputs = solver.through_windows(plant_of_run(structure, theta, run), run)
        end, y = window(node, jax.tree.map(lambda a: jax.lax.dynamic_index_in_dim(a, w, keepdims=False), inputs))
        return y, end

    def function(theta: Array, node: Array, w: Array, d_theta: Array, d_node: Array, *values: Array) -> Any:
        run = run_of(values)
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
