"""Free runs: whole logs simulated from their first state by their commands alone."""

from typing import Any

from jaxtyping import Float, Int

from rwjax.plant.structure import Structure
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT
from rwjax.simulation.program_cache import stored
from rwjax.simulation.solver import Solver
from rwjax.simulation.windows import plant_of_run


@stored(tuple)
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
    return solver.of_logs(lambda run, x0: solver.whole(plant_of_run(structure, theta, run), run, x0), batch, start)


@stored(lambda found: found[0])
def free_runs(
    structure: Structure,
    theta: Float[Any, "l t"],
    start: Float[Any, "l n"],
    windows: Int[Any, ""],
    batch: Batch,
    *,
    solver: Solver = EXACT,
) -> Any:
    """Readings of the first windows of logs from their first state, every log with numbers of its own.

    Args:
        structure: What the plant is made of.
        theta: Numbers `(l, t)` for each log [SI].
        start: First state of every log `(l, n)` [SI].
        windows: How many windows to simulate [1].
        batch: The logs.
        solver: What moves the plant through a log.

    Returns:
        Readings `(l, w, q, y)` [rad, rad/s or A]; those of later windows are 0.
    """
    return [
        solver.of_logs(
            lambda run, x0, theta: solver.beginning(plant_of_run(structure, theta, run), run, x0, windows),
            batch,
            start,
            theta,
        )
    ]
