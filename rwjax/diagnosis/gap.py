"""How far: the free-run gap on held-out logs before and after, its floor, and how sure the closure is."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import stdtrit

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.refits import refitted
from rwjax.diagnosis.settings import GapSettings
from rwjax.fitting.prediction import Prediction, errors, floor_variance, predicted
from rwjax.fitting.processes import Task
from rwjax.logs.segments import runs_of

Split = tuple[tuple[int, ...], tuple[int, ...]]
"""Numbers of the logs that a fold fits and of those on which it is judged."""


@dataclass(frozen=True)
class HeldOut:
    """Errors on the held-out logs by output: one entry for each sample that was read, log after log.

    Attributes:
        square: squared error (m,) [SI].
        floor: variance of the floor (m,) [SI], empty where it was not wanted.
        run: number of the run (m,).
        second: number of the second of all runs, or of the stretch that is resampled as a whole (m,).
        error: measured minus predicted, by log number and output (time,) [SI].
    """

    square: dict[str, np.ndarray]
    floor: dict[str, np.ndarray]
    run: dict[str, np.ndarray]
    second: dict[str, np.ndarray]
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
        ci95: 95 % interval of that share [1] for new runs of this rig under such commands, by leaving each run out in turn; None
            below three held-out runs, and where `before` of the others is not above their floor.
        at_most: upper end of a 95 % interval of that share on these very runs [1], by resampling their seconds; None where that
            gives none.
    """

    before: float
    after: float
    floor: float
    closed: float | None
    ci95: tuple[float, float] | None
    at_most: float | None

    @property
    def size(self) -> float:
        """How far the gap stands above the floor [1], in floors."""
        return float(np.sqrt(max(self.before**2 - self.floor**2, 0.0)) / self.floor)


def held_out(
    fits: ModelFits, hypotheses: Sequence[Hypothesis], folds: Sequence[Split], *, with_floor: bool
) -> list[HeldOut]:
    """Free-run errors of hypotheses on every fold's held-out logs, fitted to the rest of the fold.

    Args:
        fits: fits to the training logs, those of the hypotheses among them, each at its end.
        hypotheses: the hypotheses to judge.
        folds: the logs that each fold fits and those on which it is judged.
        with_floor: whether the floor is worked out as well.

    Returns:
        The errors of each hypothesis.
    """
    cases = [(e, train) for e in hypotheses for train, _ in folds]
    runs = []
    for (e, _), (_, test), theta in zip(cases, [*folds] * len(hypotheses), refitted(fits, cases), strict=True):
        problem = fits.problem_of(e)
        runs.append(Task(problem, partial(predicted, problem, theta, test, with_floor=with_floor)))
    found = fits.together(runs)
    n = len(folds)
    return [_errors(fits, found[k * n : (k + 1) * n], with_floor=with_floor) for k in range(len(hypotheses))]


def _errors(fits: ModelFits, by_fold: Sequence[list[Prediction]], *, with_floor: bool) -> HeldOut:
    """Errors of one hypothesis by its predictions of every fold."""
    limits, runs = fits.settings.gap, runs_of(fits.problem.logs)
    square: dict[str, list[np.ndarray]] = {}
    floor: dict[str, list[np.ndarray]] = {}
    run: dict[str, list[np.ndarray]] = {}
    second: dict[str, list[np.ndarray]] = {}
    error: dict[int, dict[str, np.ndarray]] = {}
    for predictions in by_fold:
        variance = floor_variance(fits.problem, predictions) if with_floor else [{} for _ in predictions]
        for prediction, found, floors in zip(predictions, errors(fits.problem, predictions), variance, strict=True):
            k, log = prediction.log, fits.problem.logs[prediction.log]
            error[k] = {}
            for name, raw in found.items():
                seen = np.isfinite(log.outputs[name])
                e = limited(raw, limits)
                error[k][name] = np.where(seen, e, np.nan)
                square.setdefault(name, []).append(e[seen] ** 2)
                stretch = k * 100_000 + np.floor((log.time - log.time[0]) / limits.block)
                second.setdefault(name, []).append(stretch[seen])
                run.setdefault(name, []).append(np.full(int(np.sum(seen)), int(runs[k])))
                if with_floor:
                    floor.setdefault(name, []).append(floors[name][seen])
    return HeldOut(_joined(square), _joined(floor), _joined(run), _joined(second), error)


def limited(error: np.ndarray, limits: GapSettings) -> np.ndarray:
    """Errors of which the squares can be summed.

    Args:
        error: errors of a free run [SI], which may have left the range of numbers.
        limits: limits of the gap.

    Returns:
        The errors, none further off than `limits.diverged` [SI].
    """
    most = limits.diverged
    return np.nan_to_num(np.clip(error, -most, most), nan=most)


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
    """Gap of one output, with how sure its closure is.

    Args:
        before: errors of the rig as it is, with their floor.
        after: errors with the named effects.
        name: the output.
        limits: how the intervals are drawn.

    Returns:
        The gap.
    """
    squares = np.stack([before.square[name], after.square[name], before.floor[name]])
    b, a, f = (float(e) for e in np.sqrt(np.mean(squares, axis=1)))
    closed = closure(b, a, f)
    if closed is None or after is before:  # where nothing is added, no closure has an interval
        return Gap(b, a, f, closed, None, None)
    of_runs = _of_new_runs(closed, squares, before.run[name], limits)
    return Gap(b, a, f, closed, of_runs, _at_most(squares, before.second[name], limits))


def _sums(squares: np.ndarray, group: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sums of squares of each group (3, g), and how many samples it has (g,)."""
    _, group = np.unique(group, return_inverse=True)
    return np.stack([np.bincount(group, weights=square) for square in squares]), np.bincount(group)


def _of_new_runs(
    closed: float, squares: np.ndarray, run: np.ndarray, limits: GapSettings
) -> tuple[float, float] | None:
    """95 % interval of the closure by Student's distribution, with the spread that leaving each run out in turn tells (the jackknife).

    What is left of the gap is a ratio, and its logarithm is nearer to a normal variable. Where it is not told from nothing, it has none.
    """
    total, count = _sums(squares, run)
    n = len(count)
    if n < limits.fewest_runs:
        return None
    others = 1.0 - np.eye(n)  # no difference: one run that left the range of numbers would wipe out all others
    b, a, f = np.sqrt((total @ others) / (count @ others))
    with np.errstate(all="ignore"):
        left = 1.0 - (b - a) / (b - f)
    if not np.all(np.isfinite(left)) or np.any(b <= f):
        return None
    wide = float(stdtrit(n - 1, 0.975) * (n - 1.0) / np.sqrt(n))
    reach, whole = wide * float(np.std(left, ddof=1)), 1.0 - closed
    if whole <= reach or np.any(left <= 0.0):
        return closed - reach, closed + reach
    factor = float(np.exp(wide * np.std(np.log(left), ddof=1)))
    return 1.0 - factor * whole, 1.0 - whole / factor


def _at_most(squares: np.ndarray, second: np.ndarray, limits: GapSettings) -> float | None:
    """The upper end of a 95 % interval of the closure on these runs; None where no draw of their seconds has one."""
    total, count = _sums(squares, second)
    rng = np.random.default_rng(0)
    at_once = max(limits.at_once // len(count), 1)
    blocks = [min(at_once, limits.resamples - k) for k in range(0, limits.resamples, at_once)]
    draws = (rng.integers(0, len(count), (rows, len(count))) for rows in blocks)
    means = [total[:, drawn].sum(axis=-1) / count[drawn].sum(axis=-1) for drawn in draws]
    b, a, f = np.sqrt(np.concatenate(means, axis=1))
    with np.errstate(all="ignore"):
        values = ((b - a) / (b - f))[b > f]
    values = values[np.isfinite(values)]
    return float(np.quantile(values, 0.975)) if len(values) else None


def headline(gaps: dict[str, Gap]) -> str:
    """The output whose gap stands furthest above its floor.

    Args:
        gaps: gaps by output, at least one.

    Returns:
        The output with the largest (before² - floor²)/floor².
    """
    return max(gaps, key=lambda name: (gaps[name].before ** 2 - gaps[name].floor ** 2) / gaps[name].floor ** 2)
