"""Free runs: whole logs simulated from their first state by their commands alone."""

from typing import Any

import jax
import numpy as np
from jax.core import Tracer
from jaxtyping import Float, Int

from rwjax.plant.structure import Structure
from rwjax.simulation import machine_code
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT
from rwjax.simulation.program_cache import stored
from rwjax.simulation.solver import Solver
from rwjax.simulation.windows import plant_of_run

ROWS = 16
"""Runs in one call of XLA's program: a run in a full call costs a third of a call of its own."""


def free_run(
    structure: Structure,
    theta: Float[Any, " t"],
    start: Float[Any, "l n"],
    batch: Batch,
    *,
    solver: Solver = EXACT,
) -> Any:
    """Readings of whole logs from their first state, and the states at the windows' starts.

    Args:
        structure: What the plant is made of.
        theta: Numbers of all logs `(t,)` [SI].
        start: First state of every log `(l, n)` [SI].
        batch: The logs.
        solver: What moves the plant through a log.

    Returns:
        Readings `(l, w, q, y)` [rad, rad/s or A] and states `(l, w, n)` [SI].
    """
    if not any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves((theta, start, batch))):
        theta, start = np.asarray(theta), np.asarray(start)
        found = [_of_log(structure, theta, x, batch, log, solver) for log, x in enumerate(start)]
        if found and all(run is not None for run in found):
            return tuple(np.concatenate(part) for part in zip(*found, strict=True))
    return _free_run(structure, theta, start, batch, solver=solver)


def _of_log(
    structure: Structure, theta: np.ndarray, start: np.ndarray, batch: Batch, log: int, solver: Solver
) -> tuple[np.ndarray, np.ndarray] | None:
    """`free_run` of one log by machine code, with a first axis of one run."""
    own = theta[batch.theta_index[log]] + batch.theta_offset[log]
    alone = batch.of(log).with_own_numbers(len(own))
    return machine_code.runs(structure, own[None], start[None], batch.windows, alone, solver)


@stored(tuple)
def _free_run(structure: Structure, theta: Any, start: Any, batch: Batch, *, solver: Solver = EXACT) -> Any:
    """`free_run` through XLA."""
    return solver.of_logs(lambda run, x0: solver.whole(plant_of_run(structure, theta, run), run, x0), batch, start)


def free_runs(
    structure: Structure,
    theta: Float[np.ndarray, "b t"],
    start: Float[np.ndarray, "b n"],
    windows: int,
    batch: Batch,
    *,
    solver: Solver = EXACT,
) -> Float[np.ndarray, "b w q y"]:
    """Readings of the first windows of one log, of several runs with numbers and first states of their own.

    Args:
        structure: What the plant is made of.
        theta: Numbers `(b, t)` for each run [SI].
        start: First states `(b, n)` [SI].
        windows: How many windows to simulate [1].
        batch: The log.
        solver: What moves the plant through it.

    Returns:
        Readings `(b, w, q, y)` [rad, rad/s or A].
    """
    found = machine_code.runs(structure, theta, start, windows, batch, solver)
    if found is not None:
        found = found[0]
    else:
        b = len(theta)
        fill = -b % ROWS
        theta, start = (np.concatenate([a, np.repeat(a[-1:], fill, axis=0)]) for a in (theta, start))
        runs = batch.inputs_of(np.zeros(b + fill, int))
        found = np.asarray(_free_runs(structure, theta, start, np.array(windows), runs, solver=solver))[:b]
    return found[:, :windows]


@stored(lambda found: found[0])
def _free_runs(
    structure: Structure, theta: Any, start: Any, windows: Int[Any, ""], batch: Batch, *, solver: Solver = EXACT
) -> Any:
    """`free_runs` through XLA."""
    return [
        solver.of_logs(
            lambda run, x0, theta: solver.beginning(plant_of_run(structure, theta, run), run, x0, windows)[0],
            batch,
            start,
            theta,
        )
    ]
