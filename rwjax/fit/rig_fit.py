"""Fit of a rig file's free numbers to logs: from `Rig` and `Log` to a fitted `Rig`."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rwjax.build import bounds_of, rig_with, structure_of, theta_of
from rwjax.errors import LogError, RigError
from rwjax.fit.anchored import fit_anchored
from rwjax.fit.coordinates import coordinates
from rwjax.fit.end_to_end import Fit, fit, reaches_noise
from rwjax.fit.nodes import measured_nodes
from rwjax.fit.problem import pose
from rwjax.fit.scales import sizes_of
from rwjax.fit.uncertainty import Uncertainty, strongly_tied, uncertainty
from rwjax.log import Log
from rwjax.rig import Rig

OFF_BY = (1.0, 0.5, 2.0)
"""Factors on all free numbers from which a fit is started, until one of them reaches the noise."""


@dataclass(frozen=True)
class RigFit:
    """Fitted rig with what the optimum says. `rms`: free-run RMS of every output over the fitted logs [SI]."""

    rig: Rig
    fit: Fit
    uncertainty: Uncertainty
    rms: dict[str, float]

    @property
    def notes(self) -> tuple[str, ...]:
        """What a user should know, one sentence each."""
        return self.uncertainty.notes

    def json(self) -> dict:
        """Plain objects for `rwjax fit --json`."""
        value = self.fit.numbers()
        errors = self.uncertainty.standard_error
        return {
            "schema": "rwjax.fit/1",
            "numbers": {
                name: {"value": value[name], "standard_error": e if np.isfinite(e) else None}
                for name, e in errors.items()
            },
            "covariance": [[float(v) if np.isfinite(v) else None for v in row] for row in self.uncertainty.covariance],
            "rms": self.rms,
            "noise": self.fit.problem.noise,
            "converged": self.fit.converged,
            "notes": list(self.uncertainty.notes),
        }


def to_fit(rig: Rig, logs: Sequence[Log]) -> list[Log]:
    """The logs that may be fitted. Raises `RigError` where nothing is free and `LogError` where no log is left."""
    if not rig.free:
        raise RigError(
            f'rig `{rig.name}`: [fit] free names nothing; list the numbers to estimate, e.g. free = ["axis.inertia"]'
        )
    train = [log for log in logs if not log.validate]
    if not train:
        raise LogError("every log is marked `# role: validate`; give at least one log to fit")
    return train


def fit_rig(rig: Rig, logs: Sequence[Log], *, refine: int = 1) -> RigFit:
    """End-to-end fit of the free numbers of `rig` to all `logs` that are not marked for validation.

    Raises `RigError` where nothing is free and `LogError` where no log may be fitted.
    """
    train = to_fit(rig, logs)
    structure = structure_of(rig)
    problem = pose(structure, train, refine=refine)
    theta = theta_of(rig, structure)
    bounds = bounds_of(rig, structure)
    free = np.array([name in rig.free for name in structure.names])
    moves = coordinates(theta, free, bounds, sizes_of(rig, structure, theta, train))
    tried = []
    for factor in OFF_BY:
        begin = moves.inward(np.where(free, factor * theta, theta))
        tried.append(fit(problem, moves, begin, nodes=measured_nodes(problem, begin), most_steps=10))
        if reaches_noise(tried[-1].cost, problem):
            break
    best = min(tried, key=lambda f: f.cost)
    best = fit_anchored(problem, moves, best.theta, best.start)
    spread = uncertainty(best)
    spread = replace(
        spread,
        notes=(
            *spread.notes,
            *(f"{a} and {b} are hardly told apart (correlation {c:+.3f})" for a, b, c in strongly_tied(spread)),
        ),
    )
    notes = spread.notes if best.converged else (*spread.notes, "the fit did not settle within its step limit")
    spread = Uncertainty(spread.names, spread.covariance, notes)
    known = {name: e for name, e in spread.standard_error.items() if np.isfinite(e)}
    return RigFit(rig_with(rig, structure, best.theta, known), best, spread, _rms(best))


def _rms(fitted: Fit) -> dict[str, float]:
    problem = fitted.problem
    found = {}
    for y, name in enumerate(problem.structure.outputs):
        seen = problem.batch.weight[..., y] > 0.0
        if seen.any():
            error = fitted.evaluation.residual[..., y][seen] / problem.batch.weight[..., y][seen]
            found[name] = float(np.sqrt(np.mean(error**2)))
    return found
