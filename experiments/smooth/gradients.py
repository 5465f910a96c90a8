"""Whether the derivatives that a fit goes by say how the sum of squares changes: against central finite differences."""

from collections.abc import Sequence

import numpy as np

from rwjax import Log, Rig
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.sensitivities import residual_jacobian, run_costs, sensitivities
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.solver import Solver

POINTS = 3  # numbers tried
AROUND = 0.1  # logarithm within which they lie about the true ones
STEP = 1e-4  # of a number, in units of itself
OFF = 0.1  # relative difference above which a derivative counts as wrong


def slopes(problem: Problem, theta: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives `(k,)` of the sum of squares by some numbers: the fit's own, and by central finite differences."""

    def cost(at: np.ndarray) -> float:
        return float(np.sum(run_costs(problem, at, problem.start)[0]))

    _, nodes = run_costs(problem, theta, problem.start)
    e, k = sensitivities(problem, theta, numbers, nodes), len(numbers)
    own = sum(
        np.einsum("wqyk,wqy->k", residual_jacobian(e, log)[..., :k], e.residual[log]) for log in range(len(nodes))
    )
    moved = STEP * np.abs(theta) * np.eye(len(theta))[numbers]
    with np.errstate(invalid="ignore"):
        secant = [(cost(theta + d) - cost(theta - d)) / (2.0 * d.max()) for d in moved]
    return np.asarray(own), np.array(secant)


def gradients(rig: Rig, logs: Sequence[Log], solver: Solver) -> tuple[float, float]:
    """Share of points about a rig's numbers at which no finite derivative comes out, and share of the others that are off."""
    structure, rng = structure_of(rig), np.random.default_rng(0)
    problem = pose(structure, logs, solver=solver.suited(rig, logs))
    numbers = np.flatnonzero([name in rig.free for name in structure.names])
    refused, off = [], []
    for _ in range(POINTS):
        theta = theta_of(rig, structure)
        theta[numbers] *= np.exp(rng.uniform(-AROUND, AROUND, len(numbers)))
        own, secant = slopes(problem, theta, numbers)
        bad = not np.isfinite([own, secant]).all()
        refused.append(bad)
        off += [] if bad else list(np.abs(own - secant) > OFF * np.maximum(np.abs(own), np.abs(secant)))
    return float(np.mean(refused)), float(np.mean(off)) if off else float("nan")
