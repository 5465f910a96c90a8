"""How far: the free-run gap on held-out logs before and after, its floor, and how sure the closure is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.settings import GapSettings
from rwjax.fitting.batched_runs import Simulating, together
from rwjax.fitting.prediction import Prediction, errors, floor_variance, predicted

Split = tuple[tuple[int, ...], tuple[int, ...]]
"""Numbers of the logs that a fold fits and of those on which it is judged."""


@dataclass(frozen=True)
class HeldOut:
    """Errors on the held-out logs by output: one entry for each sample that was read, log after log.

    Attributes:
        square: squared error (m,) [SI].
        floor: variance of the floor (m,) [SI], empty where it was not wanted.
        block: number of the block of samples that are resampled together (m,).
        error: measured minus predicted, by log number and output (time,) [SI].
    """

    square: dict[str, np.ndarray]
    floor: dict[str, np.ndarray]
    block: dict[str, np.ndarray]
    error: dict[int, dict[str, np.ndarray]]

    def rms(self, name: str) -> float:
        """RMS error of an output [SI].

        Args:
            name: the output.

        Returns:
            Root of the mean squared error over all held-out logs [SI].
        """
        return float(np.sqrt(np.mean(self.square[name])))


@dataclass(frozen=True)
class Gap:
    """Gap of one output on the held-out logs.

    Attributes:
        before: RMS error of the rig as it is [SI].
        after: RMS error with the named effects [SI].
        floor: RMS error that noise and unknown first states leave of a right rig [SI].
        closed: share of the gap above the floor that is closed [1], None where `before` is not above the floor.
        ci95: 95 % interval of that share [1], None where resampling gives none.
    """

    before: float
    after: float
    floor: float
    closed: float | None
    ci95: tuple[float, float] | None

    @property
    def size(self) -> float:
        """How far the gap stands above the floor [1], in floors."""
        return float(np.sqrt(max(self.before**2 - self.floor**2, 0.0)) / self.floor)


def held_out(fits: ModelFits, hypothesis: Hypothesis, folds: Sequence[Split], *, with_floor: bool) -> HeldOut:
    """Free-run errors of a hypothesis on every fold's held-out logs, fitted to the rest of the fold.

    Args:
        fits: fits to the training logs, that of the hypothesis among them.
        hypothesis: the hypothesis to judge.
        folds: the logs that each fold fits and those on which it is judged.
        with_floor: whether the floor is worked out as well.

    Returns:
        The errors.
    """
    limits = fits.settings.gap
    square: dict[str, list[np.ndarray]] = {}
    floor: dict[str, list[np.ndarray]] = {}
    block: dict[str, list[np.ndarray]] = {}
    error: dict[int, dict[str, np.ndarray]] = {}

    begun = fits(hypothesis)

    def judged(fold: Split) -> Simulating[list[Prediction]]:
        train, test = fold
        fitted = begun if set(train) == set(fits.train) else (yield from fits.on(hypothesis, train).begin())
        problem = fits.problem_of(hypothesis).only(test)
        return (yield from predicted(problem, fitted.theta, test, with_floor=with_floor))

    for predictions in together([judged(fold) for fold in folds]):
        variance = floor_variance(fits.problem, predictions) if with_floor else [{} for _ in predictions]
        for prediction, found, floors in zip(predictions, errors(fits.problem, predictions), variance, strict=True):
            k, log = prediction.log, fits.problem.logs[prediction.log]
            error[k] = found
            for name, e in found.items():
                seen = np.isfinite(log.outputs[name])
                e = np.where(np.isfinite(e), e, limits.diverged)
                square.setdefault(name, []).append(e[seen] ** 2)
                group = k * 100_000 + np.floor((log.time - log.time[0]) / limits.block)
                block.setdefault(name, []).append(group[seen])
                if with_floor:
                    floor.setdefault(name, []).append(floors[name][seen])
    return HeldOut(_joined(square), _joined(floor), _joined(block), error)


def _joined(parts: dict[str, list[np.ndarray]]) -> dict[str, np.ndarray]:
    """The parts of every output, one after the other."""
    return {name: np.concatenate(arrays) for name, arrays in parts.items()}


def closure(before: float, after: float, floor: float) -> float | None:
    r"""Share of the gap above the floor that is closed [1].

    $(e_\mathrm{before} - e_\mathrm{after}) / (e_\mathrm{before} - e_\mathrm{floor})$.

    Args:
        before: RMS error of the rig as it is [SI].
        after: RMS error with the named effects [SI].
        floor: RMS error of the floor [SI].

    Returns:
        The share [1], None where `before` is not above the floor.
    """
    return (before - after) / (before - floor) if before > floor * 1.001 else None


def gap(before: HeldOut, after: HeldOut, name: str, limits: GapSettings) -> Gap:
    """Gap of one output, its closure with a 95 % interval from resampled blocks.

    Args:
        before: errors of the rig as it is, with their floor.
        after: errors with the named effects.
        name: the output.
        limits: how the interval is drawn.

    Returns:
        The gap.
    """
    floor_square = before.floor[name]
    b, a, f = before.rms(name), after.rms(name), float(np.sqrt(np.mean(floor_square)))
    closed = closure(b, a, f)
    if closed is None:
        return Gap(b, a, f, None, None)
    _, group = np.unique(before.block[name], return_inverse=True)
    total = np.stack([np.bincount(group, weights=x) for x in (before.square[name], after.square[name], floor_square)])
    count = np.bincount(group)
    drawn = np.random.default_rng(0).integers(0, len(count), (limits.resamples, len(count)))
    rb, ra, rf = np.sqrt(total[:, drawn].sum(axis=-1) / count[drawn].sum(axis=-1))
    with np.errstate(all="ignore"):
        values = ((rb - ra) / (rb - rf))[rb > rf]
    values = values[np.isfinite(values)]
    if not len(values):
        return Gap(b, a, f, closed, None)
    low, high = np.percentile(values, [2.5, 97.5])
    return Gap(b, a, f, closed, (float(low), float(high)))


def headline(gaps: dict[str, Gap]) -> str:
    """The output whose gap stands furthest above its floor.

    Args:
        gaps: gaps by output, at least one.

    Returns:
        The output with the largest (before² - floor²)/floor².
    """
    return max(gaps, key=lambda name: (gaps[name].before ** 2 - gaps[name].floor ** 2) / gaps[name].floor ** 2)
