"""Headway of a search: how far it has come, what leads, and about how long it still takes, in one line."""

import time
from collections.abc import Callable, Collection
from math import isfinite
from threading import Lock
from typing import TypeVar

import numpy as np

from rwjax.diagnosis.budget import Budget
from rwjax.diagnosis.hypothesis import Hypothesis, spoken
from rwjax.diagnosis.information_criterion import residuals
from rwjax.fitting.multiple_shooting import Fit
from rwjax.rig.columns import unit_of

T = TypeVar("T")


class Headway:
    """What a search has done and has still to do. Its work goes in passes over some hypotheses each.

    Work is counted in hypotheses. The time that is left follows from the time that a hypothesis has taken so far.

    Attributes:
        budget: when the search has to end.
        signal: the output by whose error a hypothesis is told.
        compared: hypotheses that were compared, those of every pass.
    """

    def __init__(
        self,
        budget: Budget | None = None,
        tell: Callable[[str], None] = lambda text: None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.budget = Budget() if budget is None else budget
        self.signal: str | None = None
        self.compared: set[Hypothesis] = set()
        self._tell, self._clock, self._lock = tell, clock, Lock()
        self._begun: float | None = None  # time of the first pass
        self._what, self._of = "candidates", frozenset[Hypothesis]()
        self._doing = ""  # what is done besides the comparison of the pass
        self._whole, self._further = 0.0, 0.0
        self._done, self._before = 0.0, 0.0  # work of this pass and of those before it
        self._shown, self._least = np.inf, np.inf  # time left as told last, and before this pass [s]
        self._best: tuple[float, str] = np.inf, ""

    def say(self, text: str) -> None:
        """Tells of a step outside the search.

        Args:
            text: the step, in words.
        """
        self._tell(text)

    def enter(self, hypotheses: Collection[Hypothesis], what: str, *, besides: float, further: float) -> None:
        """Begins a pass.

        Args:
            hypotheses: those that it compares.
            what: what they are, in words.
            besides: work of the pass besides their comparison [hypotheses].
            further: work of the passes that follow it [hypotheses].
        """
        with self._lock:
            self._begun = self._clock() if self._begun is None else self._begun
            self._before += self._done
            self._what, self._of, self._doing = what, frozenset(hypotheses), ""
            self._whole, self._further, self._done = len(self._of - self.compared) + besides, further, 0.0
            self._least, self._shown = min(self._least, self._shown), np.inf

    def advance(self, work: float) -> None:
        """Counts work that was done, and tells how far the search is.

        Args:
            work: the work [hypotheses].
        """
        with self._lock:
            self._done = min(self._done + work, self._whole)
            text = self._line()
        if text:
            self._tell(text)

    def doing(self, text: str) -> None:
        """Says what is done besides the comparison of the pass, which was not counted as work.

        Args:
            text: what is done, in words; empty where that has come to its end.
        """
        with self._lock:
            self._doing = text

    def compare(self, hypothesis: Hypothesis) -> None:
        """Counts a hypothesis as compared.

        Args:
            hypothesis: the hypothesis.
        """
        with self._lock:
            self.compared.add(hypothesis)

    def lead(self, hypothesis: Hypothesis, fitted: Fit) -> None:
        """Takes down a fit that leaves less than every one before it.

        Args:
            hypothesis: its hypothesis.
            fitted: the fit.
        """
        if not (self.signal and hypothesis.names and fitted.cost < self._best[0]):
            return
        left = np.concatenate(
            residuals(fitted, fitted.problem.logs_with_readings.tolist()).get(self.signal, [np.zeros(1)])
        )
        rms = fitted.problem.noise[self.signal] * float(np.sqrt(np.mean(left**2)))
        words = (
            f"{' and '.join(map(spoken, hypothesis.names))} ({rms:.3g} {unit_of(self.signal)} left of the fitted runs)"
        )
        with self._lock:
            self._best = min(self._best, (fitted.cost, words))

    @property
    def best(self) -> str:
        """What leaves least of the fitted runs so far, in words, with the error that it leaves; empty before a fit was taken down."""
        return self._best[1]

    @property
    def left(self) -> float | None:
        """About how long the search still takes [s], and no longer than its budget; None before a tenth of the first pass is done."""
        done = self._before + self._done
        early = not self._before and done < 0.1 * self._whole  # helpers start and programs are compiled
        if self._begun is None or not done or early:
            return None
        pace = (self._clock() - self._begun) / done
        return min(pace * (self._whole - self._done + self._further), self.budget.left)

    def _line(self) -> str:
        """How far the search is; empty before the first pass.

        Within a pass the time left only falls. A pass that was not foreseen says so, and how long the budget lets all of them take. What is done
        besides is told without a time, but for what the budget lets it take.
        """
        if self._begun is None:
            return ""
        parts = [f"{len(self._of & self.compared)} of {len(self._of)} {self._what}"]
        if self.best:
            parts.append(f"best so far {self.best}")
        most = self.budget.left  # read before what is told as left, which is no longer then
        at_most = f"at most {max(round(most), 1)} s" if isfinite(most) else ""
        if self._doing:
            return ", ".join([parts[0], self._doing, *parts[1:], *[f"{at_most} left"] * bool(at_most)])
        if (left := self.left) is not None:
            self._shown = min(self._shown, left)
            about = max(round(self._shown), 1)
            goes_on = "the search goes on, " if self._shown > self._least + 0.5 else ""
            parts.append(f"{goes_on}about {about} s left" + (f" ({at_most})" if at_most else ""))
        return ", ".join(parts)
