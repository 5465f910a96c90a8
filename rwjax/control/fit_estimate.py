"""What a fit says of a rig's numbers: estimates and covariance, and plants drawn from them."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from rwjax.errors import InputError
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.text_files import read_text

TRIES = 100
"""Rounds of drawing, in which draws beyond the physical bounds are replaced."""


class FitEstimate(NamedTuple):
    """What a fit says of some numbers of a rig.

    Attributes:
        names: Names of the numbers.
        mean: Their estimates [SI], `(n,)`.
        covariance: Covariance of the estimates [SI], `(n, n)`.
        per_run: Names of those of which every run has a value of its own. Their mean stands in `mean`, and the scatter
            between the runs counts in `covariance`, since a plant is a run.
    """

    names: tuple[str, ...]
    mean: Float[np.ndarray, " n"]
    covariance: Float[np.ndarray, "n n"]
    per_run: tuple[str, ...] = ()


def read_fit_estimate(path: Path, rig: Rig) -> FitEstimate:
    """Reads what `rwjax fit --json` or a diagnosis wrote for a rig.

    Args:
        path: The file.
        rig: The rig of which it has to be a fit.

    Returns:
        Estimates and covariance.

    Raises:
        InputError: For anything else, for a fit of another rig, and for numbers of which the logs say nothing.
    """
    try:
        found = json.loads(read_text(path, InputError))
        if (fitted := found.get("rig", rig.name)) != rig.name:
            raise InputError(f"{path}: is a fit of rig `{fitted}`, not of `{rig.name}`; give the rig file of that fit")
        if "numbers" in found and "covariance_of" not in found:
            raise InputError(f"{path}: no `covariance`, as of the two-stage method; fit end to end")
        shared = {name: name.split(" in ")[0] for name in found["covariance_of"]}  # `NAME in LOG`: a run's own
        silent = [name for k, name in enumerate(shared) if found["covariance"][k][k] is None]
        if silent:
            raise InputError(
                f"{path}: `covariance`: the logs say nothing of {', '.join(silent)}; take it out of fit.free"
            )
        values = np.array([found["numbers"][name]["value"] for name in shared], float)
        covariance = np.array(found["covariance"], float).reshape(len(shared), len(shared))
        if not (np.isfinite(values).all() and np.isfinite(covariance).all()):
            raise InputError(f"{path}: a value or a covariance is not finite; make the file anew")
    except (json.JSONDecodeError, AttributeError, KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{path}: is not what `rwjax fit RIG LOG… --json` prints, nor a `diagnosis.json`; save one to a file"
        ) from None
    _check_names(path, rig, {*shared.values()})
    return _means_of_runs(shared, values, covariance)


def _check_names(path: Path, rig: Rig, names: set[Any]) -> None:
    """Raises `InputError` for a fit of nothing, and for one without a number of an effect that the rig frees."""
    if not names:
        raise InputError(f"{path}: `covariance_of` is empty, the fit estimates no number; leave --fit out")
    of_effects = (name for name in rig.free if name.rpartition(".")[0] in rig.effects)  # as a diagnosis adds them
    if (other := next((name for name in of_effects if name not in names), None)) is not None:
        raise InputError(f"{path}: a fit without `{other}`, which the rig file frees; run `rwjax fit` on that rig file")


def _means_of_runs(
    shared: dict[str, str], values: Float[np.ndarray, " m"], covariance: Float[np.ndarray, "m m"]
) -> FitEstimate:
    """Estimates with one entry for each number, the mean of the runs for those that every run has of its own."""
    names = tuple(dict.fromkeys(shared.values()))
    of = np.array([[number == name for number in shared.values()] for name in names], float)
    of /= of.sum(axis=1, keepdims=True)  # the mean of the runs
    per_run = tuple(dict.fromkeys(number for name, number in shared.items() if name != number))
    runs = [values[row > 0.0] for row in of]
    scatter = np.diag([np.var(own, ddof=1) if len(own) > 1 else 0.0 for own in runs])
    return FitEstimate(names, of @ values, of @ covariance @ of.T + scatter, per_run)


def with_fit_estimate(rig: Rig, estimate: FitEstimate) -> Rig:
    """A rig with a fit's estimates.

    Args:
        rig: The rig.
        estimate: What the fit says.

    Returns:
        The rig with the estimated numbers.

    Raises:
        InputError: For numbers that the rig lacks.
    """
    if unknown := [name for name in estimate.names if name not in rig.values]:
        raise InputError(f"the fit estimates `{unknown[0]}`, which this rig lacks; give the fitted rig file")
    return rig.with_values(dict(zip(estimate.names, map(float, estimate.mean), strict=True)))


def draw_plants(rig: Rig, estimate: FitEstimate, count: int, seed: int = 0) -> Float[np.ndarray, "k p"]:
    """Plants drawn from a fit's normal distribution; those beyond the physical bounds are drawn again.

    Args:
        rig: The rig.
        estimate: What the fit says.
        count: Number of plants k [1].
        seed: Seed of the random numbers [1].

    Returns:
        Parameter vectors of the rig's structure [SI], one plant for each row, `(k, p)`.

    Raises:
        InputError: As `with_fit_estimate` does, and where hardly any draw is possible.
    """
    structure = structure_of(with_fit_estimate(rig, estimate))
    at = [structure.names.index(name) for name in estimate.names]
    low, high = bounds_of(rig, structure)[at].T
    rng, found = np.random.default_rng(seed), np.empty((0, len(at)))
    for _ in range(TRIES):
        fresh = rng.multivariate_normal(estimate.mean, estimate.covariance, size=count, method="eigh")
        found = np.concatenate([found, fresh[np.all((fresh > low) & (fresh < high), axis=1)]])[:count]
        if len(found) == count:
            thetas = np.tile(theta_of(rig, structure), (count, 1))
            thetas[:, at] = found
            return thetas
    raise InputError(
        "the fit's covariance reaches far beyond what is possible; fit more logs, or fix some of its numbers"
    )
