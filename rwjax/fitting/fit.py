"""Fit of a rig file's free numbers to logs: from `Rig` and `Log` to a fitted `Rig`."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rwjax.errors import LogError, RigError
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.initial_state_from_start import COMPLETE, fit_from_start
from rwjax.fitting.intervals import Intervals, intervals
from rwjax.fitting.multiple_shooting import Fit, least_squares, reaches_noise
from rwjax.fitting.predict import unit_of
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import sizes_of
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.fitting.uncertainty import Uncertainty, memory, strongly_tied, uncertainty
from rwjax.fitting.unit_check import check_units
from rwjax.logs.log import Log
from rwjax.plant.from_rig import bounds_of, rig_with, structure_of, theta_of
from rwjax.rig.model import Rig

OFF_BY = (1.0, 0.5, 2.0)
"""Factors on all free numbers from which a fit is started, until one of them reaches the noise."""

FAR_FROM_PRIOR = 4.0
"""Standard deviations of a prior beyond which the distance from it is said."""


@dataclass(frozen=True)
class RigFit:
    """Fitted rig with what the optimum says. `rms`: free-run RMS of every output over the fitted logs [SI]. A number that
    every run has of its own stands in `rig` as the mean over the runs, with the standard error of that mean. `interval`:
    95 % of each estimated number [SI], by the sandwich's standard error; by the profile where a bound is near or the logs
    say little; by the bootstrap where one was made.
    """

    rig: Rig
    fit: Fit
    uncertainty: Uncertainty
    interval: Intervals
    rms: dict[str, float]
    notes: tuple[str, ...]
    """What a user should know, one sentence each."""

    def of_runs(self) -> list[str]:
        """One line for each number that a run has of its own."""
        value = self.fit.numbers()
        ends = {name: self.interval[name] for name in self.fit.free if name not in self.rig.free}
        return [f"{name} = {value[name]:.6g} (95 %: {low:.6g} to {high:.6g})" for name, (low, high) in ends.items()]

    def json(self) -> dict:
        """Plain objects for `rwjax fit --json`."""
        value, errors = self.fit.numbers() | self.rig.values, self.uncertainty.standard_error | self.rig.standard_error
        names = dict.fromkeys((*self.rig.free, *self.uncertainty.names))
        return {
            "schema": "rwjax.fit/1",
            "rig": self.rig.name,
            "numbers": {
                name: {"value": value[name], "standard_error": _finite(errors.get(name, np.inf))} for name in names
            },
            "interval95": {name: [_finite(end) for end in ends] for name, ends in self.interval.items()},
            "covariance_of": list(self.uncertainty.names),
            "covariance": [[_finite(v) for v in row] for row in self.uncertainty.covariance],
            "rms": self.rms,
            "noise": self.fit.problem.noise,
            "converged": self.fit.converged,
            "notes": list(self.notes),
        }


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def to_fit(rig: Rig, logs: Sequence[Log]) -> list[Log]:
    """The logs that may be fitted. Raises `RigError` where nothing is free and `LogError` where no log is left."""
    if not rig.free:
        inertia = next(name for name in rig.values if name.endswith(".inertia"))
        raise RigError(
            f'rig `{rig.name}`: [fit] free names nothing; list the numbers to estimate, such as free = ["{inertia}"]'
        )
    train = [log for log in logs if not log.validate]
    if not train:
        raise LogError("every log is marked `# role: validate`; give at least one log to fit")
    return train


def fit(rig: Rig, logs: Sequence[Log], *, bootstrap: int = 0, refine: int = 1) -> RigFit:
    """End-to-end fit of the free numbers of `rig` to all `logs` that are not marked for validation.

    `bootstrap`: refits to resampled stretches, whose percentiles are then the intervals; 0 for none.

    Raises `RigError` where nothing is free and `LogError` where no log may be fitted.
    """
    train = to_fit(rig, logs)
    structure = structure_of(rig)
    problem = pose(structure, train, per_run=rig.per_run, prior=rig.prior, refine=refine)
    shared = theta_of(rig, structure)
    estimated = {*rig.free} - {*rig.per_run}
    free = np.array([k >= len(shared) or name in estimated for k, name in enumerate(problem.names)])
    theta, bounds, size = (
        problem.expand(a) for a in (shared, bounds_of(rig, structure), sizes_of(rig, structure, shared, train))
    )
    moves = coordinates(theta, free, bounds, size, prior=bool(rig.prior))
    tried = []
    for factor in OFF_BY:
        begin = moves.clip(np.where(free, factor * theta, theta))
        tried.append(least_squares(problem, moves, begin, nodes=measured_nodes(problem, begin), most_steps=10))
        if reaches_noise(tried[-1].cost, tried[-1].theta, problem):
            break
    best = min(tried, key=lambda f: f.cost)
    best = fit_from_start(problem, moves, best.theta, best.start)
    if rig.prior:
        weighed = replace(problem, prior_weight=memory(best))
        best = fit_from_start(weighed, moves, best.theta, best.start)
    spread = uncertainty(best)
    notes = [*check_units(problem, theta), *spread.notes, *(remark for log in train for remark in log.remarks())]
    notes += [f"{a} and {b} are hardly told apart (correlation {c:+.3f})" for a, b, c in strongly_tied(spread)]
    notes += [] if best.converged else ["the fit did not settle within its step limit"]
    notes += [*_misfit(best), *_against_prior(rig, best)]
    values = best.theta[: len(shared)].copy()
    known = {name: e for name, e in spread.standard_error.items() if np.isfinite(e) and name in rig.free}
    for k, name in enumerate(rig.per_run):
        own = np.arange(len(shared) + k, len(problem.names), len(rig.per_run))
        values[structure.names.index(name)], error = _mean(best.theta[own], spread.of([problem.names[j] for j in own]))
        if np.isfinite(error):
            known[name] = error
    interval, said = intervals(best, spread, bootstrap)
    notes += said
    return RigFit(rig_with(rig, structure, values, known), best, spread, interval, _rms(best), tuple(notes))


def _misfit(fitted: Fit) -> list[str]:
    """A sentence where the logs say that the model is wrong."""
    problem = fitted.problem
    square = 2.0 * (fitted.cost - problem.prior_cost(fitted.theta)[0]) / problem.batch.readings
    if square <= COMPLETE:
        return []
    logged = np.any(problem.batch.weight > 0.0, axis=(1, 2))
    each = np.where(logged, np.sum(fitted.evaluation.residual**2, axis=(1, 2)), -1.0)
    log, output = np.unravel_index(int(np.argmax(each)), each.shape)
    name = problem.structure.outputs[output]
    miss = f"{name} of {problem.logs[log].name}, by {_rms(fitted, int(log))[name]:.3g} {unit_of(name)} RMS"
    return [
        f"the free run misses the readings by {np.sqrt(square):.3g} times their noise, most {miss}: the model lacks something, "
        "and the intervals do not tell by how much the numbers are bent; see `rwjax diagnose`"
    ]


def _against_prior(rig: Rig, fitted: Fit) -> list[str]:
    """A sentence for every number that ends far from what is known of it besides the logs."""
    value = fitted.numbers()
    away = {name: (value[name] - mean) / spread for name, (mean, spread) in rig.prior.items() if name in fitted.free}
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
    """Of every output over a log, or over all."""
    problem = fitted.problem
    found = {}
    for y, name in enumerate(problem.structure.outputs):
        weight, residual = problem.batch.weight[log, ..., y], fitted.evaluation.residual[log, ..., y]
        seen = weight > 0.0
        if seen.any():
            error = residual[seen] / weight[seen]
            found[name] = float(np.sqrt(np.mean(error**2)))
    return found
