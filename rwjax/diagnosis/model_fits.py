"""ModelFits: the rig's free numbers and an hypothesis's together, from several starts."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis, free_names, handed_on, space, structure_for
from rwjax.diagnosis.score_screen import Candidate, Screen, Screened
from rwjax.effects.library import included_numbers, limit_numbers, null_of_optional
from rwjax.fitting.batched_runs import Simulating, together
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.initial_state_from_start import COMPLETE, fit_from_start, is_complete
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.secant import descend, search_point, with_derivatives, with_residual
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.fitting.threads import on_threads
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.plant.from_rig import theta_of
from rwjax.plant.one_axis import Structure
from rwjax.rig.model import Rig

FIRST_STEPS = 6  # of every start of the rig as it is; the best one then goes on
HEATS = ((99, 1), (16, 2), (8, 4))
"""A race's heats: how many hypotheses take part, and steps of each. Those go on whose `promise_of` is least: one that begins
far off may be on its way."""
BEGIN = 4
"""Places at most from which an hypothesis takes part, those that leave least."""
SAME = 1e-9
"""Difference in cost below which two places count as one: a stop that nothing reaches may lie anywhere."""
ARRIVED = 0.01
"""Share of the parent's cost to which a place has come down to it: from afar, the way back to adding nothing looks steep."""
LONG = 7
"""Steps from every place where a single hypothesis is searched thoroughly."""
LAST = 12
"""Steps at most of those that take part to the end."""
CLOSE = 1.5
"""Cost against the best one's up to which an hypothesis takes part to the end."""
BEHIND = 20.0
"""Cost against the best finished fit's up to which an hypothesis takes part any longer."""
GLANCE = 2
"""Steps by exact derivatives, after those through short windows, that show whether more are worth while."""
FAR = 5.0
"""Factor between a fitted number and the rig file's above which a search begins from both."""
NEAR = 1.3
"""Cost against the best one's up to which a finished fit that has not converged goes on."""
TOLERANCE = 1e-3
"""Share of the cost below which a step is no gain, in a search."""
ONLY_STARTS = 2.5
"""Times the mean square of a complete model that the start rule's first states may leave of it."""
MAYBE = 8
"""Explanations at most whose misfit may so come from their first states alone, and that are fitted again."""
MOST_STEPS, LAST_DIGIT = 40, 1e-7
"""Steps at most of a fit that goes on, and the share of the cost below which a step of the reported one is no gain."""
FOLD_STEPS = 6
"""Steps at most from the estimates on all logs to those on some of them."""


def _carried_on(problem: Problem, begun: Fit, steps: int, tolerance: float = TOLERANCE) -> Simulating[Fit]:
    """A fit after some further steps, with its derivatives."""
    here = yield from with_residual(replace(begun, problem=problem))
    found = yield from descend(here, most_steps=steps, tolerance=tolerance)
    return (yield from with_derivatives(found))


def _ended(problem: Problem, begun: Fit) -> Simulating[Fit]:
    """A fit carried to the end, once more with the numbers of its form at their null where they have moved."""
    found = yield from _carried_on(problem, begun, LAST)
    theta = found.theta.copy()
    for k in found.coordinates.index:
        null = null_of_optional(problem.structure.names[k])
        theta[k] = theta[k] if null is None else null
    if np.array_equal(theta, found.theta):
        return found
    again = yield from _carried_on(problem, replace(found, theta=theta), LAST)
    return min(found, again, key=lambda f: f.cost)


def _exactly(problem: Problem, begun: Fit, most: float) -> Fit:
    """A fit after a glance by exact derivatives, and carried to their end where the glance leaves at most so much."""
    nodes, c = measured_nodes(problem, begun.theta), begun.coordinates
    found = least_squares(problem, c, begun.theta, start=begun.start, nodes=nodes, most_steps=GLANCE)
    return found if found.cost > most else least_squares(problem, c, found.theta, start=found.start)


def promise_of(cost: float, before: float, parent: float) -> float:
    """Cost if the next heat, of twice the steps, brings a fit twice as far, in proportion, as the last one brought it from
    `before`; one that began above the parent's cost and has come down to it has gained what it leaves less than the parent."""
    begun = min(before, parent) if cost <= (1.0 + ARRIVED) * parent else before
    return cost * min(cost / begun, 1.0) ** 2 if 0.0 < begun < np.inf else cost


@dataclass
class ModelFits:
    """All logs laid out once, and the fit of every hypothesis to the training logs, done when first asked for.

    First states follow the start rule until an hypothesis is complete; from then on they are free in all fits that were
    carried to the end, and in those whose misfit may come from their first states alone.
    """

    rig: Rig
    problem: Problem
    train: tuple[int, ...]
    progress: Callable[[str], None]
    _problems: dict[Structure, Problem] = field(default_factory=dict)
    _training: dict[Structure, Problem] = field(default_factory=dict)
    _spaces: dict[Hypothesis, tuple[Coordinates, list[np.ndarray]]] = field(default_factory=dict)
    _done: dict[Hypothesis, Fit] = field(default_factory=dict)
    _finished: set[Hypothesis] = field(default_factory=set)
    _exact: dict[Hypothesis, bool] = field(default_factory=dict)
    """Explanations fitted by exact derivatives, and whether that was by the start rule."""
    _ruled: bool = True

    @classmethod
    def of(cls, rig: Rig, logs: Sequence[Log], train: Sequence[int], progress: Callable[[str], None]) -> "ModelFits":
        """ModelFits of `rig` to `logs`, trained on those numbered in `train`."""
        noise = pooled_noise(tuple(logs[k] for k in train))
        unseen = pooled_noise(tuple(logs))  # for outputs that no training log holds
        return cls(
            rig, pose(structure_for(rig, Hypothesis()), logs, unseen | noise, prior=rig.prior), tuple(train), progress
        )

    def __call__(self, hypothesis: Hypothesis) -> Fit:
        """Best fit of an hypothesis, carried to the end."""
        if hypothesis not in self._finished:
            if not hypothesis.names:
                begun = self._begin()
                found = fit_from_start(begun.problem, begun.coordinates, begun.theta, begun.start)
                self._ruled = bool(found.problem.initial_state_from_start.any())
                self._done[hypothesis] = found
            else:
                if hypothesis not in self._done:
                    self.race([hypothesis], Hypothesis())
                if hypothesis in self._finished:
                    return self._done[hypothesis]
                self._done[hypothesis] = together([self._to_the_end(self._done[hypothesis])])[0]
            self._finished.add(hypothesis)
        return self._done[hypothesis]

    def start_from_first_readings(self) -> None:
        """Takes the rig as it is by the start rule, until an hypothesis is complete: something is missing, though it reaches
        the noise where first states may hide it."""
        begun = self(Hypothesis())
        if not self._ruled and begun.problem.start_free.any():
            self._ruled = True
            found = least_squares(begun.problem.from_start, begun.coordinates, begun.theta, start=begun.start)
            self._done[Hypothesis()] = found

    def known(self, hypothesis: Hypothesis) -> Fit:
        """Best fit of an hypothesis as far as a race has brought it."""
        return self._done[hypothesis] if hypothesis in self._done else self(hypothesis)

    def places(self, hypothesis: Hypothesis) -> int:
        """From how many places an hypothesis may begin."""
        return len(self._space(hypothesis)[1])

    def ended(self, hypothesis: Hypothesis) -> bool:
        """Whether the fit of an hypothesis was carried to the end."""
        return hypothesis in self._finished

    def __contains__(self, hypothesis: Hypothesis) -> bool:
        return hypothesis in self._done

    def _begin(self) -> Fit:
        """The start of the rig as it is that the first few steps bring furthest."""
        self.progress("the rig as it is")
        nothing = Hypothesis()
        problem = self.problem_of(nothing).only(self.train)
        coordinates, starts = self._space(nothing)
        begin = [(start, nodes) for start in starts for nodes in (measured_nodes(problem, start), None)]

        def tried(start: np.ndarray, nodes: np.ndarray | None) -> Fit:
            return least_squares(problem, coordinates, start, nodes=nodes, most_steps=FIRST_STEPS)

        return min(on_threads(tried, *zip(*begin, strict=True)), key=lambda f: f.cost)

    def _posed(self, structure: Structure) -> Problem:
        if structure not in self._problems:
            posed = pose(structure, self.problem.logs, self.problem.noise, prior=self.rig.prior)
            own = posed.batch
            alike = self.problem.batch._replace(
                theta_index=own.theta_index, theta_offset=own.theta_offset
            )  # free runs need no windows of their own
            self._problems[structure] = replace(posed, batch=alike)
        return self._problems[structure]

    def _of_training(self, structure: Structure) -> Problem:
        if structure not in self._training:
            self._training[structure] = self._posed(structure).only(self.train)
        problem = self._training[structure]
        return problem.from_start if self._ruled else problem

    def problem_of(self, hypothesis: Hypothesis) -> Problem:
        """All logs with the structure of an hypothesis."""
        return self._posed(structure_for(self.rig, hypothesis))

    def _space(self, hypothesis: Hypothesis) -> tuple[Coordinates, list[np.ndarray]]:
        if hypothesis not in self._spaces:
            self._spaces[hypothesis] = space(self.rig, hypothesis, [self.problem.logs[k] for k in self.train])
        return self._spaces[hypothesis]

    def _in_order(self, structure: Structure, values: dict[str, float]) -> np.ndarray:
        """Numbers by name in the order of a structure, those not given at their null."""
        return np.array([values.get(n, v) for n, v in zip(structure.names, theta_of(self.rig, structure), strict=True)])

    def _candidate(self, hypothesis: Hypothesis, parent: Hypothesis) -> Candidate:
        """What an hypothesis is screened with, from a parent's estimates."""
        structure = structure_for(self.rig, hypothesis)
        problem = self._of_training(structure)
        moves, starts = self._space(hypothesis)
        own = {*free_names(self.rig, hypothesis)}
        shared = {*free_names(self.rig, parent)} & own
        values = self(parent).numbers()
        for name, same in handed_on(included_numbers(), own - shared, {*free_names(self.rig, parent)}):
            values[name] = values[same]
            shared.add(name)
        known = np.array([name in shared for name in structure.names])
        free = np.array([name in own for name in structure.names])
        added = free & ~known
        null = theta_of(self.rig, structure)
        bases = [np.where(known, self._in_order(structure, values), start) for start in starts]
        lost = any(self._lost(name, values[name]) for name in shared)  # what the rig lacks may have driven them there
        alike = dict(handed_on(limit_numbers(), own - shared, {*free_names(self.rig, parent)}))
        bounds = np.tile([-np.inf, np.inf], (len(null), 1))
        bounds[moves.index] = moves.bounds
        off, start = np.where(added, null, bases[0]), self._start(problem, self(parent))
        besides = [*(starts if lost else ())]
        if alike:
            handed = [values[alike[name]] if name in alike else bases[0][k] for k, name in enumerate(structure.names)]
            besides.append(np.array(handed))
        return Candidate(problem, start, off, bases, besides, free, added & (null == 0.0), bounds)

    def _lost(self, name: str, value: float) -> bool:
        """Whether a positive number of the rig was fitted far from what the rig file says."""
        said = self.rig.numbers.get(name, 0.0)
        return said > 0.0 and not said / FAR <= value <= said * FAR

    def _start(self, problem: Problem, fitted: Fit) -> np.ndarray:
        """First states of a fit in another structure's order."""
        start = problem.start.copy()
        for k, name in enumerate(fitted.problem.structure.states):
            if name in problem.structure.states:
                start[:, problem.structure.states.index(name)] = fitted.start[:, k]
        return start

    def race(self, hypotheses: Iterable[Hypothesis], parent: Hypothesis) -> dict[Hypothesis, Fit]:
        """Fits of several hypotheses side by side, from a parent's estimates, in heats: those that leave least go on.

        What comes close to the best after the last heat is fitted to the end. What lost an earlier race runs again, and so
        does a special case of the parent, which may know a better place. Of more hypotheses than the last heat takes, the one
        that promises most is carried to its end by exact derivatives.
        """
        wanted = list(dict.fromkeys(hypotheses))
        if not wanted:
            return {}
        new = [e for e in wanted if e not in self._finished or parent.contains(e) or e.contains(parent)]
        promise = self._heats(new, parent)
        least = self._least((parent, *wanted))
        ahead = [e for e in sorted(new, key=promise.__getitem__) if promise[e] <= CLOSE * least][: HEATS[-1][0]]
        again = [e for e in new if e in self._finished and e not in ahead]  # what it knows may be a better place
        parts = [ahead[:1], ahead[1:] + again]  # how far the first one comes says which of the others may still win
        if len(new) > HEATS[-1][0] and not self._finished & {*ahead[:1]}:
            self.exactly(ahead[:1])
            parts = parts[1:] if self._finished & {*ahead[:1]} else parts
        for part in parts:
            least = self._least((parent, *wanted))
            self._finish([e for e in part if promise[e] <= BEHIND * least or e in again or parent.contains(e)])
        self._settle()
        return {e: self._done[e] for e in wanted}

    def again(self, hypotheses: Sequence[Hypothesis], parent: Hypothesis) -> None:
        """Races hypotheses from another parent's estimates, however far they have come from their own; one that comes further
        and is left behind has to be carried to the end again."""
        ended = {e: self._done[e] for e in hypotheses if e in self._finished}
        self._finished -= {*ended}
        self.race(hypotheses, parent)
        self._finished |= {e for e, fitted in ended.items() if self._done[e] is fitted}

    def _heats(self, hypotheses: Sequence[Hypothesis], parent: Hypothesis) -> dict[Hypothesis, float]:
        """Brings hypotheses as far as the heats let them come; what each promises to leave."""
        screened, begun = self._begun(hypotheses, parent)
        running = {e: self._begin_at(e, parent, s) for e, s in screened.items()}
        self._keep(running)
        promise = {e: min(s.left, running[e].cost) for e, s in screened.items()}
        most = np.inf if self._ruled else BEHIND * self(parent).cost  # a complete parent leaves no room far above it
        for many, steps in HEATS:
            ahead = [e for e in hypotheses if promise[e] <= most or steps == 1 or parent.contains(e)]
            ahead = sorted(ahead, key=promise.__getitem__)[:many]
            runs = [(e, f) for e in ahead for f in begun[e][:BEGIN]]
            found = together([descend(f, most_steps=steps, tolerance=TOLERANCE) for _, f in runs])
            for e in ahead:
                pairs = [(f, before) for (other, before), f in zip(runs, found, strict=True) if other == e]
                running[e] = min((f for f, _ in pairs), key=lambda f: f.cost)
                promised = [promise_of(f.cost, before.cost, self(parent).cost) for f, before in pairs]
                coming = pairs[int(np.argmin(promised))]
                promise[e] = min(promised)
                begun[e] = [running[e]] if coming[0] is running[e] else [running[e], coming[0]]
            self._keep({e: running[e] for e in ahead})
        return promise

    def _least(self, hypotheses: Iterable[Hypothesis]) -> float:
        """Least cost of these hypotheses so far."""
        return min(self._done[e].cost for e in hypotheses)

    def _finish(self, hypotheses: Sequence[Hypothesis]) -> None:
        """Carries fits to the end."""
        if not hypotheses:
            return
        for e in hypotheses:
            self.progress(" + ".join(e.names) or "the rig as it is")
        ends = together([self._to_the_end(self._done[e]) for e in hypotheses])
        self._done |= zip(hypotheses, ends, strict=True)
        self._finished |= {*hypotheses}
        self._free_starts()

    def _begun(
        self, hypotheses: Sequence[Hypothesis], parent: Hypothesis
    ) -> tuple[dict[Hypothesis, Screened], dict[Hypothesis, list[Fit]]]:
        """Explanations as screened from a parent's estimates, and the places where each may begin, those that leave least
        first."""
        found = Screen(self(parent)).predict([self._candidate(e, parent) for e in hypotheses])
        screened = dict(zip(hypotheses, found, strict=True))
        places = [
            (e, replace(self._begin_at(e, parent, s), theta=theta)) for e, s in screened.items() for theta in s.begin
        ]
        begun: dict[Hypothesis, list[Fit]] = {e: [] for e in hypotheses}
        for (e, _), f in zip(places, together([with_residual(f) for _, f in places]), strict=True):
            same = any(abs(f.cost - other.cost) <= SAME * other.cost for other in begun[e])
            begun[e] += () if same else (f,)
        return screened, {e: sorted(fits, key=lambda f: f.cost) for e, fits in begun.items()}

    def search(self, hypothesis: Hypothesis, parent: Hypothesis) -> None:
        """One hypothesis on from all places where it may begin, the best of which a race may have left behind."""
        begun = self._begun([hypothesis], parent)[1][hypothesis]
        found = together([descend(f, most_steps=LONG, tolerance=TOLERANCE) for f in begun])
        best = sorted(found, key=lambda f: f.cost)[:BEGIN]
        self._keep({hypothesis: min(together([self._to_the_end(f) for f in best]), key=lambda f: f.cost)})

    def _begin_at(self, hypothesis: Hypothesis, parent: Hypothesis, screened: Screened) -> Fit:
        """An hypothesis as it stands where it was screened."""
        problem = self._of_training(structure_for(self.rig, hypothesis))
        c, _ = self._space(hypothesis)
        return search_point(problem, c, screened.theta, self._start(problem, self(parent)), screened.residual)

    def _keep(self, found: dict[Hypothesis, Fit]) -> None:
        """Takes down fits that are better than what is known, or that took steps where what is known did not."""
        for e, fitted in found.items():
            old = self._done.get(e)
            if old is None or fitted.cost <= old.cost or not old.steps:
                self._done[e] = fitted

    def _to_the_end(self, begun: Fit) -> Simulating[Fit]:
        """A fit carried to the end."""
        return _ended(self._of_training(begun.problem.structure), begun)

    def polish(self, hypothesis: Hypothesis) -> Fit:
        """The fit of an hypothesis to the last digit: by exact derivatives, then by secants, which see across the creases of
        stick and slip."""
        self.exactly([hypothesis])
        self._keep({hypothesis: together([self._polished(self(hypothesis), LAST_DIGIT)])[0]})
        return self._done[hypothesis]

    def exactly(self, hypotheses: Iterable[Hypothesis]) -> None:
        """Fits hypotheses on by exact derivatives through short windows that begin at what was measured: they go straight
        along a narrow valley where secants of whole runs creep, and find one that whole runs end before. Those whose readings
        reach back further than the windows are left as they are; once more where this frees the first states."""
        wanted = [e for e in dict.fromkeys(hypotheses) if self._exact.get(e) != self._ruled and self._within_windows(e)]
        if not wanted:
            return
        ruled, begun = self._ruled, [self.known(e) for e in wanted]
        self._exact |= dict.fromkeys(wanted, ruled)
        problems = [self._of_training(f.problem.structure) for f in begun]
        most = BEHIND * self._least(self._done)
        found = dict(zip(wanted, on_threads(partial(_exactly, most=most), problems, begun), strict=True))
        self._keep(found)
        near = [e for e in wanted if found[e].cost <= most and e not in self._finished]
        if near:
            self._finish(near)
        else:
            self._free_starts()
        if self._ruled != ruled:
            self.exactly(wanted)

    def _within_windows(self, hypothesis: Hypothesis) -> bool:
        return structure_for(self.rig, hypothesis).latest <= self.problem.structure.latest

    def _polished(self, begun: Fit, tolerance: float) -> Simulating[Fit]:
        return _carried_on(self._of_training(begun.problem.structure), begun, MOST_STEPS, tolerance)

    def _free_starts(self) -> None:
        """Frees the first states where the best finished fit is then complete: of all finished fits, and of all others whose
        misfit may come from their first states alone."""
        best = min((self._done[e] for e in self._finished), key=lambda f: f.cost)
        most = 0.5 * ONLY_STARTS * COMPLETE * best.problem.batch.readings
        if not self._ruled or best.cost > most:
            return
        self._of_training(best.problem.structure)
        if is_complete(together([_carried_on(self._training[best.problem.structure], best, FOLD_STEPS)])[0]):
            self._ruled = False
            maybe = sorted((e for e in self._done if self._done[e].cost <= most), key=lambda e: self._done[e].cost)
            self._finished |= {*maybe[:MAYBE]}
            every = [*self._finished]
            self._done |= zip(every, together([self._to_the_end(self._done[e]) for e in every]), strict=True)

    def _settle(self) -> None:
        """Carries on those of the finished fits that come close to the best one and were not at their end."""
        least = min(self._done[e].cost for e in self._finished)
        close = [e for e in self._finished if self._done[e].cost <= NEAR * least and not self._done[e].converged]
        if len(close) > 1 or any(self._done[e].cost > least for e in close):
            more = together([self._polished(self._done[e], TOLERANCE / 10.0) for e in close])
            self._keep(dict(zip(close, more, strict=True)))

    def on(self, hypothesis: Hypothesis, train: Sequence[int]) -> Simulating[Fit]:
        """Fit of an hypothesis to other logs than those marked for training, from its estimates on those."""
        begun = self(hypothesis)
        problem = self._posed(begun.problem.structure).only(train)
        start = np.where(problem.start_free, begun.start, problem.start)
        return _carried_on(problem.from_start if self._ruled else problem, replace(begun, start=start), FOLD_STEPS)
