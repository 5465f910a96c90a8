"""Left-out runs: how a hypothesis follows each training run when it is fitted to the other ones.

An effect with several numbers can follow a run that holds nearly all of the error, as a free swing among runs of a stiff loop does, and say
nothing of the others. What it leaves of that run where it was fitted to the others shows it.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np

from rwjax.diagnosis.gap import limited
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.refits import refitted
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.prediction import Prediction, errors, predicted
from rwjax.fitting.processes import Task
from rwjax.logs.segments import runs_of


class LeftOut:
    """Errors of hypotheses on training runs that they were not fitted to, each worked out once for a fit.

    Args:
        fits: where the fits are kept.

    Attributes:
        fits: where the fits are kept.
        runs: numbers of each training run's logs, by the run's number; none where there is one run alone.
    """

    def __init__(self, fits: ModelFits) -> None:
        self.fits = fits
        train, run = np.array(fits.train), runs_of(fits.problem.logs)[list(fits.train)]
        runs = {int(n): tuple(map(int, train[run == n])) for n in np.unique(run)}
        self.runs = runs if len(runs) > 1 else {}
        self._readings = dict[str, int]()
        for logs in self.runs.values():
            for k in logs:
                for name, y in fits.problem.logs[k].outputs.items():
                    self._readings[name] = self._readings.get(name, 0) + int(np.isfinite(y).sum())
        self._known: dict[Hypothesis, tuple[Fit, dict[int, dict[str, float]]]] = {}

    def __call__(self, hypothesis: Hypothesis) -> dict[int, float]:
        """Squares of each run that a hypothesis was not fitted to.

        Args:
            hypothesis: the rig as it is, or a hypothesis with a fit that a search has begun.

        Returns:
            Sum of squared errors [noise²] by the run's number; none where there is one run alone.
        """
        return {run: sum(squares.values()) for run, squares in self._squares_of(hypothesis).items()}

    def prepare(self, hypotheses: Sequence[Hypothesis]) -> None:
        """Works out the errors of several hypotheses side by side, which carries their fits to the end.

        Args:
            hypotheses: each the rig as it is or a hypothesis with a fit that a search has begun.
        """
        fits = self.fits
        fits.end([e for e in hypotheses if e.names])
        new = [e for e in dict.fromkeys(hypotheses) if e not in self._known or self._known[e][0] is not fits(e)]
        if new and self.runs:
            fits.headway.say(f"runs left out in turn, explanations: {len(new)}")
        cases = [(e, [k for k in fits.train if k not in logs]) for e in new for logs in self.runs.values()]
        judged = [
            Task(problem, partial(predicted, problem, theta, logs, with_floor=False))
            for (e, _), logs, theta in zip(cases, [*self.runs.values()] * len(new), refitted(fits, cases), strict=True)
            for problem in [fits.problem_of(e)]
        ]
        found = iter(fits.together(judged))
        for e in new:
            self._known[e] = fits(e), {n: self._squares(next(found)) for n in self.runs}

    def excess(self, hypothesis: Hypothesis) -> float:
        """Mean square of the left-out runs above the noise [1], in units of the noise, summed over outputs.

        Args:
            hypothesis: the rig as it is, or a hypothesis with a fit that a search has begun.

        Returns:
            The excess [1], 0 where the noise is reached, or where no run can be left out.
        """
        runs = self._squares_of(hypothesis).values()
        total = {name: sum(squares.get(name, 0.0) for squares in runs) for name in self._readings}
        return sum((max(total[name] / max(count, 1) - 1.0, 0.0) for name, count in self._readings.items()), 0.0)

    def _squares_of(self, hypothesis: Hypothesis) -> dict[int, dict[str, float]]:
        """Sum of squared errors [noise²] by run and output."""
        self.prepare([hypothesis])
        return self._known[hypothesis][1]

    def _squares(self, predictions: list[Prediction]) -> dict[str, float]:
        """Sum of squared errors of predictions [noise²] by output; what left the range of numbers counts as far off."""
        problem, limits, found = self.fits.problem, self.fits.settings.gap, dict[str, float]()
        for p, by_output in zip(predictions, errors(problem, predictions), strict=True):
            for name, e in by_output.items():
                seen = np.isfinite(problem.logs[p.log].outputs[name])
                square = float(np.sum((limited(e[seen], limits) / problem.noise[name]) ** 2))
                found[name] = found.get(name, 0.0) + square
        return found
