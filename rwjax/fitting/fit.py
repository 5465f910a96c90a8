"""Fit of a rig file's free numbers to logs: from `Rig` and `Log` to a fitted `Rig`."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from rwjax.errors import LogError, RigError, refuses_other_types
from rwjax.fitting.coordinates import Coordinates, coordinates
from rwjax.fitting.initial_state_from_start import COMPLETE, fit_from_start
from rwjax.fitting.intervals import intervals
from rwjax.fitting.multiple_shooting import Fit, least_squares, reaches_noise
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.questions.ask import ask
from rwjax.fitting.ran_away import negative_friction
from rwjax.fitting.rig_fit import RigFit, misfit
from rwjax.fitting.scales import sizes_of
from rwjax.fitting.segments import said, with_segments
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.fitting.threads import SINGLE_THREADED_BLAS
from rwjax.fitting.tied_errors import tied_errors
from rwjax.fitting.uncertainty import Uncertainty, readings_per_independent_one, strongly_tied, uncertainty
from rwjax.kinds import RANGES, SERVO
from rwjax.logs.coverage import split_of
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.logs.segments import cut_up, runs_of
from rwjax.plant.from_rig import bounds_of, rig_with, structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Driven, Rig
from rwjax.rig.parse import PERIOD
from rwjax.simulation.exact import EXACT
from rwjax.simulation.layout import finer
from rwjax.simulation.solver import Solver

UNSETTLED = "the fit did not settle within its step limit: fit once more from its estimates, or free fewer numbers"
OFF_BY = (1.0, 0.5, 2.0)
"""Factors on all free numbers from which a fit is started, until one of them reaches the noise [1]."""
FIRST_STEPS = 10
"""Steps from each of these starts."""
FAR_FROM_PRIOR = 4.0
"""Standard deviations of a prior beyond which a note says how far a number lies from it [1]."""


def to_fit(rig: Rig, logs: Sequence[Log]) -> list[Log]:
    """The logs that may be fitted: those not marked for validation.

    Args:
        rig: The rig with its free numbers.
        logs: All logs.

    Returns:
        The logs to fit.

    Raises:
        RigError: Nothing is free.
        LogError: No log was given, or none is left.
    """
    if not rig.free:
        inertia = next(name for name in rig.values if name.endswith(".inertia"))
        raise RigError(
            f'rig `{rig.name}`: [fit] free names nothing; list the numbers to estimate, such as free = ["{inertia}"]'
        )
    if not logs:
        raise LogError("no log was given; give at least one to fit")
    train = [log for log in logs if not log.validate]
    if not train:
        raise LogError("every log is marked `# role: validate`; give at least one log to fit")
    return train


@refuses_other_types
@SINGLE_THREADED_BLAS
def fit(
    rig: Rig,
    logs: Sequence[Log],
    *,
    bootstrap: int = 0,
    refine: int = 1,
    solver: Solver = EXACT,
    segments: float | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> RigFit:
    """Fit of a rig's free numbers to logs by free-run least squares, over whole runs where free runs can follow them.

    Args:
        rig: The rig with its free numbers, bounds and priors.
        logs: The logs; those marked for validation are left out.
        bootstrap: Refits to resampled stretches, whose percentiles are then the intervals; 0 for none [1].
        refine: Parts into which each time step is divided [1].
        solver: What moves the plant through a log.
        segments: Length of the segments [s] in which free runs follow the logs, infinite for whole runs; chosen by the
            rig and the logs without it.
        progress: Hears of what takes long.

    Returns:
        The fitted rig with standard errors, intervals, RMS errors and notes.

    Raises:
        RigError: Nothing is free, or the best free run goes further than any rig.
        LogError: No log may be fitted.
        InputError: An argument is of another type.
    """
    rig, logs = driven(rig, logs)
    runs = to_fit(rig, with_segments(rig, logs, segments))
    train = cut_up(runs)
    structure, noise = structure_of(rig), pooled_noise(tuple(runs))
    _check_free(rig, structure)
    suited, parts = solver.suited(rig, train), finer(structure, train)
    posed = partial(pose, structure, train, noise, per_run=rig.per_run, prior=rig.prior, solver=suited)
    problem = posed(refine=refine * parts)
    coarse = problem if parts == 1 or suited.smooth else posed(refine=refine)
    shared, estimated = theta_of(rig, structure), {*rig.free} - {*rig.per_run}
    free = np.array([k >= len(shared) or name in estimated for k, name in enumerate(problem.names)])
    theta, bounds, size = (
        problem.expand(a) for a in (shared, bounds_of(rig, structure), sizes_of(rig, structure, shared, train))
    )
    moves = coordinates(theta, free, bounds, size, prior=bool(rig.prior))
    begins = [moves.clip(np.where(free, factor * theta, theta)) for factor in OFF_BY]
    best = roughly = _first_fit(coarse, moves, begins, progress)
    if rig.prior:  # a prior counts as many readings as carry the information of one, which the fit now tells
        weight = readings_per_independent_one(best)
        best = roughly = _fit_again(replace(coarse, prior_weight=weight), best)
    if coarse is not problem:
        progress("fitting, in finer steps")
        best = _fit_again(replace(problem, prior_weight=roughly.problem.prior_weight), roughly)
    _check_run(rig, best)
    found = uncertainty(best)
    notes = [
        *(problem.solver.notes(rig, train) + _taken(rig, structure)),
        *ask(problem, theta),
        *found.notes,
        *(remark for log in runs for remark in log.remarks()),
        *(said(runs) + (split_of(rig, logs).said() if len(runs) < len(logs) else [])),
    ]
    notes += [f"{a} and {b} are hardly told apart (correlation {c:+.3f})" for a, b, c in strongly_tied(found)]
    notes += [] if best.converged else [UNSETTLED]
    smooth, estimate = problem.solver.acts_on(rig), _estimated_rig(rig, best, found)
    notes += [*_bent(problem.solver, smooth), *_misfit(best, smooth), *_far_from_prior(rig, best)]
    notes += negative_friction(rig.free, estimate.values)
    interval, of_intervals = intervals(best, found, bootstrap, progress, roughly)
    return RigFit(estimate, best, found, interval, _rms(best), tuple(notes + of_intervals))


def _check_free(rig: Rig, structure: Structure) -> None:
    """`RigError` for a free number that acts on nothing, as logs say how the rig was driven."""
    without = {name for name, value in rig.numbers.items() if name.endswith(".inductance") and value == 0.0}
    if idle := [name for name in rig.free if name not in structure.names and name not in without]:
        raise RigError(
            f"rig `{rig.name}`: `{idle[0]}` is free, and acts on nothing where the logs hold `{rig.driven.by}` and the drive is "
            f"given a {structure.command}; take it out of `fit.free`"
        )


def _taken(rig: Rig, structure: Structure) -> list[str]:
    """What is taken for numbers of a joint and its servo that the rig file may lack, though they matter."""
    found = []
    by_logs = "motor.torque_constant" in rig.free and "motor.inertia" not in rig.numbers  # it acts with the gear alone
    if rig.kind == "joint" and "gear.ratio" not in rig.numbers and structure.command != "torque" and not by_logs:
        found.append(
            "the rig file has no gear.ratio: 1 is taken, which is right where the motor's numbers hold behind the gear, as `rwjax init` "
            "writes them"
        )
    if structure.servo is not None and structure.servo.period == PERIOD:
        found.append(
            f"the servo is taken to tick every {1e3 * PERIOD:g} ms, as where the rig file has no `{SERVO}.period`"
        )
    return found


def _first_fit(problem: Problem, moves: Coordinates, begins: list[np.ndarray], progress: Callable[[str], None]) -> Fit:
    """The fit carried to its end from the best of several starts."""
    if problem.solver.smooth:
        from rwjax.fitting.smooth_fit import fit_smooth  # with it comes optimistix, which the exact way does not need

        return fit_smooth(problem, moves, begins, progress)
    tried = []
    for k, begin in enumerate(begins):
        progress(f"fitting, start {k + 1} of {len(begins)} at most")
        nodes = measured_nodes(problem, begin)
        tried.append(least_squares(problem, moves, begin, nodes=nodes, most_steps=FIRST_STEPS))
        if reaches_noise(tried[-1].cost, tried[-1].theta, problem):
            break
    progress("fitting, to its end")
    return fit_from_start(min(tried, key=lambda f: f.cost))


def _fit_again(problem: Problem, fitted: Fit) -> Fit:
    """The fit to a problem with other priors or finer steps, from an earlier one."""
    if problem.solver.smooth:
        from rwjax.fitting.smooth_fit import fit_again

        return fit_again(problem, fitted)
    return fit_from_start(least_squares(problem, fitted.coordinates, fitted.theta, start=fitted.start, most_steps=0))


def _estimated_rig(rig: Rig, fitted: Fit, errors: Uncertainty) -> Rig:
    """The rig with estimates and standard errors, of numbers of every run the mean over the runs; not how it was driven."""
    problem, structure = fitted.problem, fitted.problem.structure
    count = len(structure.names)
    values = fitted.theta[:count].copy()
    known = {name: e for name, e in errors.standard_error.items() if np.isfinite(e) and name in rig.free}
    for k, name in enumerate(rig.per_run):
        own = np.arange(count + k, len(problem.names), len(rig.per_run))
        mean, error = _mean(fitted.theta[own], errors.of([problem.names[j] for j in own]))
        values[structure.names.index(name)] = mean
        if np.isfinite(error):
            known[name] = error
    estimated = replace(rig_with(rig, structure, values, known), driven=Driven())
    if rig.tied:
        names, covariance = _of_rig(rig, problem, errors, known)
        of_tied = tied_errors(rig.tied, estimated.values, names, covariance)
        estimated = estimated.with_standard_errors(known | of_tied)
    return estimated


def _of_rig(
    rig: Rig, problem: Problem, errors: Uncertainty, known: dict[str, float]
) -> tuple[tuple[str, ...], np.ndarray]:
    """The estimated numbers of a rig and their covariance; of those of every run that of the mean, with its own scatter."""
    names = tuple(name for name in rig.free if name in problem.names)
    mean = np.zeros((len(names), len(errors.names)))
    for k, name in enumerate(names):
        own = [j for j, one in enumerate(errors.names) if one.partition(" in ")[0] == name]
        mean[k, own] = 1.0 / len(own)
    unknown = ~np.isfinite(np.diag(errors.covariance))
    covariance = mean @ np.where(np.isfinite(errors.covariance), errors.covariance, 0.0) @ mean.T
    covariance[np.diag_indices(len(names))] = [known.get(name, np.inf) ** 2 for name in names]
    covariance[(mean[:, unknown] > 0.0).any(axis=1)] = np.inf
    return names, covariance


def _check_run(rig: Rig, fitted: Fit) -> None:
    """`RigError` where the best free run misses the readings by more than any rig moves, or is not finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        rms = _rms(fitted)
    for name, error in rms.items():
        if not error <= (most := RANGES[unit_of(name)].most):
            raise RigError(
                f"rig `{rig.name}`: the best free run misses {name} by {error:.3g} {unit_of(name)}, and no rig goes beyond "
                f"{most:g}; check the numbers that are not estimated"
            )


def _bent(solver: Solver, smooth: bool) -> list[str]:
    """A sentence on what the width of a smooth sign does to the numbers."""
    if not smooth:
        return []
    return [
        "the numbers make up for the width of the sign, and their standard errors do not say by how much: a fit by the exact solver "
        f"does; their own free run takes --smooth {solver.sign_width:.6g}, or Smooth(width={solver.sign_width:.6g})"
    ]


def _misfit(fitted: Fit, smooth: bool) -> list[str]:
    """A sentence where the logs say that the model is wrong."""
    problem, times = fitted.problem, misfit(fitted)
    if times**2 <= COMPLETE:
        return []
    logged = np.any(problem.batch.weight > 0.0, axis=(1, 2))
    each = np.where(logged, np.sum(fitted.evaluation.residual**2, axis=(1, 2)), -1.0)
    log, output = np.unravel_index(int(np.argmax(each)), each.shape)
    name = problem.structure.outputs[output]
    wide = " or the smooth sign of its friction is too wide" if smooth else ""
    miss = f"{name} of {problem.logs[log].name}{_where_cut(problem.logs, int(log))}, by {_rms(fitted, int(log))[name]:.3g} {unit_of(name)} RMS"
    return [
        f"the free run misses the readings by {times:.3g} times their noise, most {miss}: the model lacks something{wide}, "
        "and the intervals do not tell by how much the numbers are bent; see `rwjax diagnose`"
    ]


def _where_cut(logs: Sequence[Log], log: int) -> str:
    """Which part of its run a log is, nothing where it is a whole one."""
    run, time = runs_of(logs), logs[log].time
    return f" from {time[0]:.4g} to {time[-1]:.4g} s" if np.sum(run == run[log]) > 1 else ""


def _far_from_prior(rig: Rig, fitted: Fit) -> list[str]:
    """A sentence for every number that ends far from what is known of it besides the logs."""
    value = fitted.numbers()
    away = {name: (value[name] - mean) / sd for name, (mean, sd) in rig.prior.items() if name in fitted.free}
    return [
        f"{name} ends {abs(z):.3g} standard deviations from its prior"
        for name, z in away.items()
        if abs(z) > FAR_FROM_PRIOR
    ]


def _mean(own: np.ndarray, covariance: np.ndarray) -> tuple[float, float]:
    """Mean of the values of several runs with its standard error: that of the estimates, and what they scatter more."""
    count = len(own)
    estimated = float(np.sum(covariance)) / count**2
    if count == 1 or not np.isfinite(estimated):
        return float(np.mean(own)), float(np.sqrt(estimated))
    expected = (float(np.trace(covariance)) - float(np.sum(covariance)) / count) / (count - 1)
    return float(np.mean(own)), float(np.sqrt(estimated + max(float(np.var(own, ddof=1)) - expected, 0.0) / count))


def _rms(fitted: Fit, log: int | slice = slice(None)) -> dict[str, float]:
    """RMS error [SI] of every output over a log, or over all."""
    problem = fitted.problem
    found = {}
    for y, name in enumerate(problem.structure.outputs):
        weight, residual = problem.batch.weight[log, ..., y], fitted.evaluation.residual[log, ..., y]
        seen = weight > 0.0
        if seen.any():
            error = residual[seen] / weight[seen]
            found[name] = float(np.sqrt(np.mean(error**2)))
    return found
