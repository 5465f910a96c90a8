"""How far: the free-run gap on held-out logs before and after, its floor, and how sure the closure is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.fitting.batched_runs import Simulating, together
from rwjax.fitting.prediction import Prediction, errors, floor_variance, predicted

BLOCK_S = 1.0  # errors closer than this are resampled together
RESAMPLES = 2000
FAR_OFF = 1e6
"""Error [SI] of a run that left the range of numbers."""
Split = tuple[tuple[int, ...], tuple[int, ...]]
"""Numbers of the logs that a fold fits and of those on which it is judged."""


@dataclass(frozen=True)
class Held:
    """Held-out squares by output: one entry for each sample of all held-out logs, in order; `block` groups them."""

    square: dict[str, np.ndarray]
    floor: dict[str, np.ndarray]
    block: dict[str, np.ndarray]
    error: dict[int, dict[str, np.ndarray]]
    """Measured minus predicted by log number and output."""

    def rms(self, name: str) -> float:
        """RMS error of an output [SI]."""
        return float(np.sqrt(np.mean(self.square[name])))


@dataclass(frozen=True)
class Gap:
    """Gap of one output [SI]. `closed` = (before - after)/(before - floor), None where before is not above the floor."""

    before: float
    after: float
    floor: float
    closed: float | None
    ci95: tuple[float, float] | None

    @property
    def size(self) -> float:
        """How far the gap stands above the floor, in floors."""
        return float(np.sqrt(max(self.before**2 - self.floor**2, 0.0)) / self.floor)


def held_out(fits: ModelFits, hypothesis: Hypothesis, folds: Sequence[Split], *, with_floor: bool) -> Held:
    """Free-run errors of an hypothesis on every fold's held-out logs, fitted on the rest of the fold."""
    square: dict[str, list[np.ndarray]] = {}
    floor: dict[str, list[np.ndarray]] = {}
    block: dict[str, list[np.ndarray]] = {}
    error: dict[int, dict[str, np.ndarray]] = {}

    begun = fits(hypothesis)

    def judged(fold: Split) -> Simulating[list[Prediction]]:
        train, test = fold
        fitted = begun if set(train) == set(fits.train) else (yield from fits.on(hypothesis, train))
        problem = fits.problem_of(hypothesis).only(test)
        return (yield from predicted(problem, fitted.theta, test, with_floor=with_floor))

    for predictions in together([judged(fold) for fold in folds]):
        variance = floor_variance(fits.problem, predictions) if with_floor else [{} for _ in predictions]
        for prediction, found, floors in zip(predictions, errors(fits.problem, predictions), variance, strict=True):
            k, log = prediction.log, fits.problem.logs[prediction.log]
            error[k] = found
            for name, e in found.items():
                seen = np.isfinite(log.outputs[name])
                e = np.where(np.isfinite(e), e, FAR_OFF)
                square.setdefault(name, []).append(e[seen] ** 2)
                group = k * 100_000 + np.floor((log.time - log.time[0]) / BLOCK_S)
                block.setdefault(name, []).append(group[seen])
                if with_floor:
                    floor.setdefault(name, []).append(floors[name][seen])
    join = {name: np.concatenate(parts) for name, parts in square.items()}
    return Held(
        join,
        {name: np.concatenate(parts) for name, parts in floor.items()},
        {name: np.concatenate(parts) for name, parts in block.items()},
        error,
    )


def closure(before: float, after: float, floor: float) -> float | None:
    """Share of the gap above the floor that is closed."""
    return (before - after) / (before - floor) if before > floor * 1.001 else None


def gap(before: Held, after: Held, name: str) -> Gap:
    """Gap of one output, its closure with a 95 % interval from resampled blocks of one second."""
    floor_square = before.floor[name]
    b, a, f = before.rms(name), after.rms(name), float(np.sqrt(np.mean(floor_square)))
    closed = closure(b, a, f)
    if closed is None:
        return Gap(b, a, f, None, None)
    _, group = np.unique(before.block[name], return_inverse=True)
    total = np.stack([np.bincount(group, weights=x) for x in (before.square[name], after.square[name], floor_square)])
    count = np.bincount(group)
    drawn = np.random.default_rng(0).integers(0, len(count), (RESAMPLES, len(count)))
    rb, ra, rf = np.sqrt(total[:, drawn].sum(axis=-1) / count[drawn].sum(axis=-1))
    with np.errstate(all="ignore"):
        values = np.where(rb > rf, (rb - ra) / (rb - rf), np.nan)
    low, high = np.nanpercentile(values, [2.5, 97.5])
    return Gap(b, a, f, closed, (float(low), float(high)))


def headline(gaps: dict[str, Gap]) -> str:
    """The output with the largest (before² - floor²)/floor²."""
    return max(gaps, key=lambda name: (gaps[name].before ** 2 - gaps[name].floor ** 2) / gaps[name].floor ** 2)
