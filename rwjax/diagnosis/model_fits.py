"""ModelFits: the best fit of every hypothesis to the training logs, and how one is carried to its end."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

import numpy as np

from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.headway import Headway
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis, logged_outputs, space, structure_for
from rwjax.diagnosis.settings import FittingSettings, Settings
from rwjax.effects.library import null_of_optional
from rwjax.fitting.batched_runs import Simulating, together
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.initial_state_from_start import COMPLETE, fit_from_start, is_complete
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.processes import ALONE, Task, Team
from rwjax.fitting.secant import descend, with_derivatives, with_residual
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.fitting.threads import on_threads
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.logs.segments import whole_runs
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig

T = TypeVar("T")


def _carried_on(problem: Problem, begun: Fit, steps: int, tolerance: float) -> Simulating[Fit]:
    """A fit after some further steps, with its derivatives."""
    here = yield from with_residual(replace(begun, problem=problem))
    found = yield from descend(here, most_steps=steps, tolerance=tolerance)
    return (yield from with_derivatives(found))


def _ended(problem: Problem, begun: Fit, limits: FittingSettings) -> Simulating[Fit]:
    """A fit carried to its end, and once more with the numbers of its effects' forms at their null where they have moved."""
    found = yield from _carried_on(problem, begun, limits.last_steps, limits.tolerance)
    theta = found.theta.copy()
    for k in found.coordinates.index:
        null = null_of_optional(problem.structure.names[k])
        theta[k] = theta[k] if null is None else null
    if np.array_equal(theta, found.theta):
        return found
    again = yield from _carried_on(problem, replace(found, theta=theta), limits.last_steps, limits.tolerance)
    return min(found, again, key=lambda f: f.cost)


def _carried_on_elsewhere(problem: Problem, begun: Fit, steps: int, tolerance: float) -> Task[Fit]:
    return Task(problem, partial(_carried_on, problem, begun, steps, tolerance))


@dataclass
class ModelFits:
    """All logs laid out once, and the best fit of every hypothesis to the training logs.

    First states follow the start rule until a hypothesis is complete. From then on they are free in all fits that were carried to
    their end, and in those whose misfit may come from their first states alone.

    Attributes:
        rig: the rig as it is.
        problem: all logs with the rig's own structure.
        train: numbers of the training logs.
        settings: limits of the diagnosis.
        headway: how far the search is, and when it has to end.
        team: the processes that share the searches.
        by_start_rule: whether first states follow the start rule.
        fitted_exactly: hypotheses fitted by exact derivatives, and whether that was by the start rule.
    """

    rig: Rig
    problem: Problem
    train: tuple[int, ...]
    settings: Settings
    headway: Headway
    team: Team
    by_start_rule: bool = True
    fitted_exactly: dict[Hypothesis, bool] = field(default_factory=dict)
    _problems: dict[Structure, Problem] = field(default_factory=dict)
    _training: dict[Structure, Problem] = field(default_factory=dict)
    _spaces: dict[Hypothesis, tuple[Coordinates, list[np.ndarray]]] = field(default_factory=dict)
    _best: dict[Hypothesis, Fit] = field(default_factory=dict)
    _finished: dict[Hypothesis, None] = field(default_factory=dict)
    _fitted_from: dict[Hypothesis, tuple[float, bool, set[Hypothesis]]] = field(default_factory=dict)
    _first: tuple[Fit, bool] | None = None

    @classmethod
    def of(
        cls,
        rig: Rig,
        logs: Sequence[Log],
        train: Sequence[int],
        settings: Settings | None = None,
        headway: Headway | None = None,
        team: Team | None = None,
    ) -> "ModelFits":
        """Fits of a rig to logs, none of them done yet.

        Args:
            rig: the rig as it is.
            logs: all logs.
            train: numbers of the logs to fit.
            settings: limits of the diagnosis, the usual ones where none are given.
            headway: takes down how far the search is; without it there is no limit and nobody hears.
            team: the processes that share the searches, this one alone where none are given.

        Returns:
            The empty store.
        """
        noise = pooled_noise(whole_runs([logs[k] for k in train]))
        unseen = pooled_noise(whole_runs(logs))  # for outputs that no training log holds
        problem = pose(structure_for(rig, NOTHING), logs, unseen | noise, prior=rig.prior)
        return cls(
            rig,
            replace(problem, shares_programs=True),
            tuple(train),
            Settings() if settings is None else settings,
            headway or Headway(),
            team or ALONE,
        )

    @property
    def outputs(self) -> frozenset[str]:
        """Names of the outputs that the training logs hold."""
        return logged_outputs(self.problem.logs[k] for k in self.train)

    def __call__(self, hypothesis: Hypothesis) -> Fit:
        """Best fit of a hypothesis, carried to its end.

        Args:
            hypothesis: the rig as it is, or a hypothesis with a fit that a search has begun.

        Returns:
            The fit.

        Raises:
            KeyError: no search has begun a fit of the hypothesis.
        """
        if hypothesis not in self._finished:
            if not hypothesis.names:
                found = fit_from_start(self._begin())
                self.by_start_rule = bool(found.problem.initial_state_from_start.any())
            elif hypothesis in self._best:
                found = together([self._to_the_end(self._best[hypothesis]).begin()])[0]
            else:
                raise KeyError(f"no search has begun a fit of {' + '.join(hypothesis.names)}")
            self.put(hypothesis, found, ended=True)
        return self._with_derivatives(hypothesis)

    def _with_derivatives(self, hypothesis: Hypothesis) -> Fit:
        """The fit of a hypothesis; a search that was stopped may have bettered one and left it without derivatives."""
        if not self._best[hypothesis].evaluation.local.size:
            self.put(hypothesis, together([with_derivatives(self._best[hypothesis])])[0], ended=True)
        return self._best[hypothesis]

    def start_from_first_readings(self) -> None:
        """Fits the rig as it is by the start rule, until a hypothesis is complete.

        Something is missing, though the rig reaches the noise where first states may hide it.
        """
        begun = self(NOTHING)
        if not self.by_start_rule and begun.problem.start_free.any():
            self.by_start_rule = True
            self.put(
                NOTHING, least_squares(begun.problem.from_start, begun.coordinates, begun.theta, start=begun.start)
            )
        self._first = self._best[NOTHING], self.by_start_rule

    @contextmanager
    def as_first_fitted(self) -> Iterator[None]:
        """Puts the rig as it is, and the start rule, back to how they were before any hypothesis was fitted: for reading alone, while the context lasts.

        Yields:
            Nothing.
        """
        now = self._best[NOTHING], self.by_start_rule
        self._best[NOTHING], self.by_start_rule = self._first or now
        try:
            yield
        finally:
            self._best[NOTHING], self.by_start_rule = now

    def as_it_stands(self, hypothesis: Hypothesis) -> Fit:
        """Takes the fit of a hypothesis for one at its end, however far a search has come.

        Args:
            hypothesis: a hypothesis with a fit that a search has begun.

        Returns:
            The fit, with its derivatives.
        """
        if hypothesis not in self._finished:
            self.put(hypothesis, together([with_derivatives(self._best[hypothesis])])[0], ended=True)
        return self._with_derivatives(hypothesis)

    def together(
        self,
        searches: Sequence[Task[T]],
        work: float = 0.0,
        done: Callable[[int, T], None] = lambda number, found: None,
    ) -> list[T]:
        """Results of several searches that end with the budget.

        Args:
            searches: searches that have not begun.
            work: what all of them count for [hypotheses].
            done: takes the number and the result of each that is done, on any thread.

        Returns:
            What each search returns, in the given order.

        Raises:
            Stopped: the budget has ended.
        """

        def counted(number: int, found: T) -> None:
            done(number, found)
            self.headway.advance(work / len(searches))

        budget = self.headway.budget
        return self.team.together(searches, budget.check, budget.heeded, counted)

    def known(self, hypothesis: Hypothesis) -> Fit:
        """Best fit of a hypothesis as far as a search has brought it.

        Args:
            hypothesis: the rig as it is, or a hypothesis with a fit that a search has begun.

        Returns:
            The fit.
        """
        return self._best[hypothesis] if hypothesis in self._best else self(hypothesis)

    def ended(self, hypothesis: Hypothesis) -> bool:
        """Whether the fit of a hypothesis was carried to its end.

        Args:
            hypothesis: any hypothesis.

        Returns:
            True where it was.
        """
        return hypothesis in self._finished

    def stepped(self, hypothesis: Hypothesis) -> bool:
        """Whether a search has taken a step towards the fit of a hypothesis, or has ended it.

        Args:
            hypothesis: any hypothesis.

        Returns:
            True where it has; of others no more is known than where they were screened.
        """
        return self.ended(hypothesis) or (hypothesis in self._best and self._best[hypothesis].steps > 0)

    def __contains__(self, hypothesis: Hypothesis) -> bool:
        return hypothesis in self._best

    def __iter__(self) -> Iterator[Hypothesis]:
        return iter(self._best)

    def least(self, hypotheses: Iterable[Hypothesis]) -> float:
        """Least cost of some hypotheses so far [1].

        Args:
            hypotheses: hypotheses with a fit that has begun, at least one.

        Returns:
            Half the sum of squares of the residual [1].
        """
        return min(self._best[e].cost for e in hypotheses)

    def put(self, hypothesis: Hypothesis, fitted: Fit, *, ended: bool = False) -> None:
        """Takes a fit down in the place of what is known.

        Args:
            hypothesis: its hypothesis.
            fitted: the fit.
            ended: whether it was carried to its end.
        """
        self._best[hypothesis] = fitted
        if ended:
            self._finished[hypothesis] = None

    def keep(self, found: Mapping[Hypothesis, Fit]) -> None:
        """Takes down fits that are better than what is known, or that replace a point of which no step was taken.

        Args:
            found: fits by hypothesis.
        """
        for e, fitted in found.items():
            old = self._best.get(e)
            if old is None or fitted.cost <= old.cost or not old.steps:
                self._best[e] = fitted

    def take_down(self, parent: Hypothesis, hypotheses: Iterable[Hypothesis]) -> None:
        """Takes down that hypotheses are fitted from a parent's estimates, as these are now.

        Args:
            parent: the parent.
            hypotheses: the hypotheses.
        """
        self._fitted_from[parent] = self._best[parent].cost, self.by_start_rule, {*hypotheses}

    def fitted_from(self, parent: Hypothesis, hypotheses: Iterable[Hypothesis]) -> bool:
        """Whether hypotheses were fitted from a parent's estimates, and these have not become better since.

        Args:
            parent: the parent.
            hypotheses: the hypotheses.

        Returns:
            True where to fit them once more would begin at the same places.
        """
        cost, by_start_rule, before = self._fitted_from.get(parent, (np.inf, self.by_start_rule, set()))
        as_then = by_start_rule == self.by_start_rule
        better = cost > (1.0 + self.settings.fitting.tolerance) * self._best[parent].cost
        return as_then and not better and before.issuperset(hypotheses)

    def reopen(self, hypotheses: Iterable[Hypothesis]) -> dict[Hypothesis, Fit]:
        """Lets a search go on with fits that were carried to their end.

        Args:
            hypotheses: any hypotheses.

        Returns:
            The fits of those that were at their end; `close_again` takes them.
        """
        ended = {e: self._best[e] for e in hypotheses if e in self._finished}
        self._finished = {e: None for e in self._finished if e not in ended}
        return ended

    def close_again(self, ended: Mapping[Hypothesis, Fit]) -> None:
        """Marks fits as at their end that `reopen` has opened and no search has bettered.

        Args:
            ended: what `reopen` has returned.
        """
        self._finished |= {e: None for e, fitted in ended.items() if self._best[e] is fitted}

    def _begin(self) -> Fit:
        """The start of the rig as it is that the first few steps bring furthest."""
        self.headway.say("the rig as it is")
        problem = self.problem_of(NOTHING).only(self.train)
        coordinates, starts = self.space(NOTHING)
        begin = [(start, nodes) for start in starts for nodes in (measured_nodes(problem, start), None)]

        def tried(start: np.ndarray, nodes: np.ndarray | None) -> Fit:
            return least_squares(problem, coordinates, start, nodes=nodes, most_steps=self.settings.fitting.first_steps)

        return min(on_threads(tried, *zip(*begin, strict=True)), key=lambda f: f.cost)

    def _posed(self, structure: Structure) -> Problem:
        """All logs with a structure, of the outputs that they hold."""
        structure = structure.reading(self.problem.structure.outputs)
        if structure not in self._problems:
            posed = pose(
                structure, self.problem.logs, self.problem.noise, prior=self.rig.prior, solver=self.problem.solver
            )
            own = posed.batch
            alike = self.problem.batch._replace(
                theta_index=own.theta_index, theta_offset=own.theta_offset
            )  # free runs need no windows of their own
            self._problems[structure] = replace(posed, batch=alike, shares_programs=True)
        return self._problems[structure]

    def _with_free_starts(self, structure: Structure) -> Problem:
        """The training logs with a structure, first states free."""
        structure = structure.reading(self.problem.structure.outputs)
        if structure not in self._training:
            self._training[structure] = self._posed(structure).only(self.train)
        return self._training[structure]

    def training(self, structure: Structure) -> Problem:
        """The training logs with a structure, first states as they are at this time of the search.

        Args:
            structure: the plant's structure.

        Returns:
            The problem to fit.
        """
        problem = self._with_free_starts(structure)
        return problem.from_start if self.by_start_rule else problem

    def problem_of(self, hypothesis: Hypothesis) -> Problem:
        """All logs with the structure of a hypothesis.

        Args:
            hypothesis: any hypothesis.

        Returns:
            The problem, first states free.
        """
        return self._posed(structure_for(self.rig, hypothesis))

    def space(self, hypothesis: Hypothesis) -> tuple[Coordinates, list[np.ndarray]]:
        """Coordinates of a hypothesis's fit, and numbers from which it may begin.

        Args:
            hypothesis: any hypothesis.

        Returns:
            The coordinates, and one or more parameter vectors (t,) [SI].
        """
        if hypothesis not in self._spaces:
            logs, wrong_by = [self.problem.logs[k] for k in self.train], self.settings.screening.wrong_by
            self._spaces[hypothesis] = space(self.rig, hypothesis, logs, wrong_by)
        return self._spaces[hypothesis]

    def finish(self, hypotheses: Sequence[Hypothesis]) -> None:
        """Carries fits to their end, and frees the first states of all where one of them is then complete.

        Args:
            hypotheses: hypotheses with a fit that has begun.
        """
        if not hypotheses:
            return
        self._best |= zip(hypotheses, self.ends_of([self._best[e] for e in hypotheses]), strict=True)
        self._finished |= dict.fromkeys(hypotheses)
        self.free_starts()

    def end(self, hypotheses: Sequence[Hypothesis]) -> None:
        """Carries fits to their end, side by side, as a call of each would.

        Args:
            hypotheses: hypotheses with a fit that has begun.
        """
        begun = [e for e in hypotheses if e not in self._finished]
        for e, fitted in zip(begun, self.ends_of([self._best[e] for e in begun]), strict=True):
            self.put(e, fitted, ended=True)

    def _to_the_end(self, begun: Fit) -> Task[Fit]:
        problem = self.training(begun.problem.structure)
        return Task(problem, partial(_ended, problem, begun, self.settings.fitting))

    def ends_of(self, begun: Sequence[Fit]) -> list[Fit]:
        """Fits carried to their end without being taken down.

        Args:
            begun: fits that have begun.

        Returns:
            Each at its end.
        """
        return self.together([self._to_the_end(f) for f in begun])

    def free_starts(self) -> None:
        """Frees the first states where the best finished fit is then complete.

        That holds for all finished fits, and for others whose misfit may come from their first states alone.
        """
        limits = self.settings.fitting
        best = min((self._best[e] for e in self._finished), key=lambda f: f.cost)
        most = 0.5 * limits.only_starts * COMPLETE * best.problem.batch.readings
        if not self.by_start_rule or best.cost > most:
            return
        problem = self._with_free_starts(best.problem.structure)
        if is_complete(self.together([_carried_on_elsewhere(problem, best, limits.fold_steps, limits.tolerance)])[0]):
            self._free_starts_of(e for e in self._best if self._best[e].cost <= most)

    def free_starts_of_what_leads(self) -> None:
        """Frees the first states though nothing is complete, of all finished fits and of those others that leave least.

        What the start rule misses of a first rate grows through a free run. Beside names that leave a visible part it is one of the small causes
        of that, and each run asks for its own amount of a name.
        """
        if self.by_start_rule:
            self._free_starts_of(self._best)

    def _free_starts_of(self, hypotheses: Iterable[Hypothesis]) -> None:
        """Frees the first states in all finished fits, and in those of some hypotheses that leave least."""
        leading = sorted(hypotheses, key=lambda e: self._best[e].cost)[: self.settings.fitting.refitted]
        every = [*(self._finished | dict.fromkeys(leading))]
        self.by_start_rule = False
        try:
            ends = self.ends_of([self._best[e] for e in every])
        except Stopped:
            self.by_start_rule = True  # as in all fits that are known
            raise
        self._finished |= dict.fromkeys(every)
        self._best |= zip(every, ends, strict=True)

    def settle(self) -> None:
        """Carries on those of the finished fits that come close to the best one and have not converged."""
        limits = self.settings.fitting
        least = self.least(self._finished)
        close = [e for e in self._finished if self._best[e].cost <= limits.near * least and not self._best[e].converged]
        if len(close) > 1 or any(self._best[e].cost > least for e in close):
            self.carry_on(close, limits.tolerance / 10.0)

    def carry_on(self, hypotheses: Sequence[Hypothesis], tolerance: float) -> None:
        """Carries fits on by secant steps until none gains.

        Args:
            hypotheses: hypotheses with a fit that has begun.
            tolerance: relative gain in cost below which a step is no gain [1].
        """
        begun = [self._best[e] for e in hypotheses]
        most = self.settings.fitting.most_steps
        runs = [_carried_on_elsewhere(self.training(f.problem.structure), f, most, tolerance) for f in begun]
        self.keep(dict(zip(hypotheses, self.together(runs), strict=True)))
