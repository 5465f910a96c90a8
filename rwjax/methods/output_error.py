"""Output error: the free run is compared with the readings, by the library's own fits and as scipy users do it."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from rwjax.fitting.fit import fit, to_fit
from rwjax.fitting.problem import pose
from rwjax.fitting.sandwich import undetermined
from rwjax.fitting.scales import sizes_of
from rwjax.fitting.segments import with_segments
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.logs.segments import cut_up
from rwjax.methods.identified import Identified, estimated, left_out
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from rwjax.simulation.smooth import Smooth
from rwjax.simulation.solver import Solver

SMOOTH = Smooth()
"""The smooth solver, its width by what the encoders resolve."""


def end_to_end(rig: Rig, logs: Sequence[Log]) -> Identified:
    """The library's own fit: exact sensitivities, short windows first, unknown initial states.

    Args:
        rig: The rig with its free numbers.
        logs: The logs; those marked for validation are left out.

    Returns:
        The estimates.

    Raises:
        RigError: Nothing is free.
        LogError: No log may be fitted.
    """
    result = fit(rig, logs)
    return Identified(result.rig, result.notes)


def smooth_end_to_end(rig: Rig, logs: Sequence[Log], solver: Solver = SMOOTH) -> Identified:
    """The library's fit through smooth friction, by diffrax and optimistix.

    Args:
        rig: The rig with its free numbers.
        logs: The logs; those marked for validation are left out.
        solver: The smooth solver.

    Returns:
        The estimates, with the solver that they belong to.

    Raises:
        RigError: Nothing is free.
        LogError: No log may be fitted.
    """
    result = fit(rig, logs, solver=solver)
    return Identified(result.rig, result.notes, result.fit.problem.solver)


def finite_differences(rig: Rig, logs: Sequence[Log]) -> Identified:
    """`scipy.optimize.least_squares` over a simulation, with derivatives by differences.

    Initial states are read off the logs. The simulation is the library's, so that the comparison shows the method and
    not the speed of another integrator.

    Args:
        rig: The rig with its free numbers.
        logs: The logs; those marked for validation are left out.

    Returns:
        The estimates.

    Raises:
        RigError: Nothing is free.
        LogError: No log may be fitted.
    """
    rig, logs = driven(rig, logs)
    train = to_fit(rig, with_segments(rig, logs))
    structure = structure_of(rig)
    problem = pose(structure, cut_up(train), pooled_noise(tuple(train)), prior=rig.prior)
    theta = theta_of(rig, structure)
    free = np.flatnonzero([name in rig.free for name in structure.names])
    size = sizes_of(rig, structure, theta, train)[free]
    low, high = bounds_of(rig, structure)[free].T / size

    mean, precision = problem.prior.T

    def residual(z: np.ndarray) -> np.ndarray:
        numbers = theta.copy()
        numbers[free] = z * size
        y, _ = free_run(problem.structure, numbers, problem.start, problem.batch, solver=problem.solver)
        r = (np.asarray(y) - problem.batch.reading) * problem.batch.weight
        r = np.append(r[problem.batch.weight > 0.0], np.sqrt(precision) * (numbers - mean))
        return np.nan_to_num(r, nan=1e6, posinf=1e6, neginf=-1e6)

    best = least_squares(
        residual, np.clip(theta[free] / size, low, high), bounds=(low, np.maximum(high, low + 1e-12)), x_scale="jac"
    )
    variance = 2.0 * best.cost / max(len(best.fun) - len(free), 1)
    A = best.jac.T @ best.jac
    errors = np.where(undetermined(A), np.inf, np.sqrt(np.diag(np.linalg.pinv(A)) * variance) * size)
    names = [structure.names[k] for k in free]
    notes = left_out(rig, prior=True) + (() if best.success else ("the search did not settle",))
    return Identified(estimated(rig, names, best.x * size, errors), notes)
