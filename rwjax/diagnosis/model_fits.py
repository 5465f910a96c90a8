"""Refits: the rig's free numbers and an explanation's together, from several starts."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from rwjax.diagnosis.hypothesis import CONTACT, LEVEL, Explanation, free_names, handed_on, space, structure_for
from rwjax.diagnosis.score_screen import Candidate, Screen, Screened
from rwjax.effects import plain
from rwjax.fitting.batched_runs import Search, on_threads, together
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.initial_state_from_start import COMPLETE, complete, fit_anchored
from rwjax.fitting.multiple_shooting import Fit, fit
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.secant import derived, descend, placed, point
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled
from rwjax.plant.from_rig import theta_of
from rwjax.plant.one_axis import Structure
from rwjax.rig.model import Rig

FIRST_STEPS = 6  # of every start of the rig as it is; the best one then goes on
HEATS = ((99, 1), (16, 2), (8, 4))
"""A race's heats: how many explanations take part, and steps of each. Those go on whose `promise_of` is least: one that begins
far off may be on its way."""
BEGIN = 4
"""Places at most from which an explanation takes part, those that leave least."""
SAME = 1e-9
"""Difference in cost below which two places count as one: a stop that nothing reaches may lie anywhere."""
ARRIVED = 0.01
"""Share of the parent's cost to which a place has come down to it: from afar, the way back to adding nothing looks steep."""
LONG = 7
"""Steps from every place where a single explanation is searched thoroughly."""
LAST = 12
"""Steps at most of those that take part to the end."""
CLOSE = 1.5
"""Cost against the best one's up to which an explanation takes part to the end."""
BEHIND = 20.0
"""Cost against the best finished fit's up to which an explanation takes part any longer."""
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


def _carried_on(problem: Problem, begun: Fit, steps: int, tolerance: float = TOLERANCE) -> Search[Fit]:
    """A fit after some further steps, with its derivatives."""
    here = yield from placed(replace(begun, problem=problem))
    found = yield from descend(here, most_steps=steps, tolerance=tolerance)
    return (yield from derived(found))


def _ended(problem: Problem, begun: Fit) -> Search[Fit]:
    """A fit carried to the end, once more with the numbers of its form at their null where they have moved."""
    found = yield from _carried_on(problem, begun, LAST)
    theta = found.theta.copy()
    for k in found.coordinates.index:
        null = plain(problem.structure.names[k])
        theta[k] = theta[k] if null is None else null
    if np.array_equal(theta, found.theta):
        return found
    again = yield from _carried_on(problem, replace(found, theta=theta), LAST)
    return min(found, again, key=lambda f: f.cost)


def _exactly(problem: Problem, begun: Fit, most: float) -> Fit:
    """A fit after a glance by exact derivatives, and carried to their end where the glance leaves at most so much."""
    nodes, c = measured_nodes(problem, begun.theta), begun.coordinates
    found = fit(problem, c, begun.theta, start=begun.start, nodes=nodes, most_steps=GLANCE)
    return found if found.cost > most else fit(problem, c, found.theta, start=found.start)


def promise_of(cost: float, before: float, parent: float) -> float:
    """Cost if the next heat, of twice the steps, brings a fit twice as far, in proportion, as the last one brought it from
    `before`; one that began above the parent's cost and has come down to it has gained what it leaves less than the parent."""
    begun = min(before, parent) if cost <= (1.0 + ARRIVED) * parent else before
    return cost * min(cost / begun, 1.0) ** 2 if 0.0 < begun < np.inf else cost


@dataclass
class Refits:
    """All logs laid out once, and the fit of every explanation to the training logs, done when first asked for.

    First states follow the start rule until an explanation is complete; from then on they are free in all fits that were
    carried to the end, and in those whose misfit may come from their first states alone.
    """

    rig: Rig
    problem: Problem
    train: tuple[int, ...]
    progress: Callable[[str], None]
    _problems: dict[Structure, Problem] = field(default_factory=dict)
    _training: dict[Structure, Problem] = field(default_factory=dict)
    _spaces: dict[Explanation, tuple[Coordinates, list[np.ndarray]]] = field(default_factory=dict)
    _done: dict[Explanation, Fit] = field(default_factory=dict)
    _finished: set[Explanation] = field(default_factory=set)
    _exact: dict[Explanation, bool] = field(default_factory=dict)
    """Explanations fitted by exact derivatives, and whether that was by the start rule."""
    _ruled: bool = True

    @classmethod
    def of(cls, rig: Rig, logs: Sequence[Log], train: Sequence[int], progress: Callable[[str], None]) -> "Refits":
        """Refits of `rig` to `logs`, trained on those numbered in `train`."""
        noise = pooled(tuple(logs[k] for k in train))
        unseen = pooled(tuple(logs))  # for outputs that no training log holds
        return cls(
            rig, pose(structure_for(rig, Explanation()), logs, unseen | noise, prior=rig.prior), tuple(train), progress
        )

    def __call__(self, explanation: Explanation) -> Fit:
        """Best fit of an explanation, carried to the end."""
        if explanation not in self._finished:
            if not explanation.names:
                begun = self._begin()
                found = fit_anchored(begun.problem, begun.coordinates, begun.theta, begun.start)
                self._ruled = bool(found.problem.anchored.any())
                self._done[explanation] = found
            else:
                if explanation not in self._done:
                    self.race([explanation], Explanation())
                if explanation in self._finished:
                    return self._done[explanation]
                self._done[explanation] = together([self._to_the_end(self._done[explanation])])[0]
            self._finished.add(explanation)
        return self._done[explanation]

    def anchor(self) -> None:
        """Takes the rig as it is by the start rule, until an explanation is complete: something is missing, though it reaches
        the noise where first states may hide it."""
        begun = self(Explanation())
        if not self._ruled and begun.problem.start_free.any():
            self._ruled = True
            found = fit(begun.problem.by_rule, begun.coordinates, begun.theta, start=begun.start)
            self._done[Explanation()] = found

    def known(self, explanation: Explanation) -> Fit:
        """Best fit of an explanation as far as a race has brought it."""
        return self._done[explanation] if explanation in self._done else self(explanation)

    def places(self, explanation: Explanation) -> int:
        """From how many places an explanation may begin."""
        return len(self._space(explanation)[1])

    def ended(self, explanation: Explanation) -> bool:
        """Whether the fit of an explanation was carried to the end."""
        return explanation in self._finished

    def __contains__(self, explanation: Explanation) -> bool:
        return explanation in self._done

    def _begin(self) -> Fit:
        """The start of the rig as it is that the first few steps bring furthest."""
        self.progress("the rig as it is")
        nothing = Explanation()
        problem = self.problem_of(nothing).only(self.train)
        coordinates, starts = self._space(nothing)
        begin = [(start, nodes) for start in starts for nodes in (measured_nodes(problem, start), None)]

        def tried(start: np.ndarray, nodes: np.ndarray | None) -> Fit:
            return fit(problem, coordinates, start, nodes=nodes, most_steps=FIRST_STEPS)

        return min(on_threads(tried, *zip(*begin, strict=True)), key=lambda f: f.cost)

    def _posed(self, structure: Structure) -> Problem:
        if structure not in self._problems:
            posed = pose(structure, self.problem.logs, self.problem.noise, prior=self.rig.prior)
            own = posed.batch
            alike = self.problem.batch._replace(
                which=own.which, plus=own.plus
            )  # free runs need no windows of their own
            self._problems[structure] = replace(posed, batch=alike)
        return self._problems[structure]

    def _of_training(self, structure: Structure) -> Problem:
        if structure not in self._training:
            self._training[structure] = self._posed(structure).only(self.train)
        problem = self._training[structure]
        return problem.by_rule if self._ruled else problem

    def problem_of(self, explanation: Explanation) -> Problem:
        """All logs with the structure of an explanation."""
        return self._posed(structure_for(self.rig, explanation))

    def _space(self, explanation: Explanation) -> tuple[Coordinates, list[np.ndarray]]:
        if explanation not in self._spaces:
            self._spaces[explanation] = space(self.rig, explanation, [self.problem.logs[k] for k in self.train])
        return self._spaces[explanation]

    def _in_order(self, structure: Structure, values: dict[str, float]) -> np.ndarray:
        """Numbers by name in the order of a structure, those not given at their null."""
        return np.array([values.get(n, v) for n, v in zip(structure.names, theta_of(self.rig, structure), strict=True)])

    def _candidate(self, explanation: Explanation, parent: Explanation) -> Candidate:
        """What an explanation is screened with, from a parent's estimates."""
        structure = structure_for(self.rig, explanation)
        problem = self._of_training(structure)
        moves, starts = self._space(explanation)
        own = {*free_names(self.rig, explanation)}
        shared = {*free_names(self.rig, parent)} & own
        values = self(parent).numbers()
        for name, same in handed_on(LEVEL, own - shared, {*free_names(self.rig, parent)}):
            values[name] = values[same]
            shared.add(name)
        known = np.array([name in shared for name in structure.names])
        free = np.array([name in own for name in structure.names])
        added = free & ~known
        null = theta_of(self.rig, structure)
        bases = [np.where(known, self._in_order(structure, values), start) for start in starts]
        lost = any(self._lost(name, values[name]) for name in shared)  # what the rig lacks may have driven them there
        alike = dict(handed_on(CONTACT, own - shared, {*free_names(self.rig, parent)}))
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

    def race(self, explanations: Iterable[Explanation], parent: Explanation) -> dict[Explanation, Fit]:
        """Fits of several explanations side by side, from a parent's estimates, in heats: those that leave least go on.

        What comes close to the best after the last heat is fitted to the end. What lost an earlier race runs again, and so
        does a special case of the parent, which may know a better place. Of more explanations than the last heat takes, the one
        that promises most is carried to its end by exact derivatives.
        """
        wanted = list(dict.fromkeys(explanations))
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

    def again(self, explanations: Sequence[Explanation], parent: Explanation) -> None:
        """Races explanations from another parent's estimates, however far they have come from their own; one that comes further
        and is left behind has to be carried to the end again."""
        ended = {e: self._done[e] for e in explanations if e in self._finished}
        self._finished -= {*ended}
        self.race(explanations, parent)
        self._finished |= {e for e, fitted in ended.items() if self._done[e] is fitted}

    def _heats(self, explanations: Sequence[Explanation], parent: Explanation) -> dict[Explanation, float]:
        """Brings explanations as far as the heats let them come; what each promises to leave."""
        screened, begun = self._begun(explanations, parent)
        running = {e: self._begin_at(e, parent, s) for e, s in screened.items()}
        self._keep(running)
        promise = {e: min(s.left, running[e].cost) for e, s in screened.items()}
        most = np.inf if self._ruled else BEHIND * self(parent).cost  # a complete parent leaves no room far above it
        for many, steps in HEATS:
            ahead = [e for e in explanations if promise[e] <= most or steps == 1 or parent.contains(e)]
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

    def _least(self, explanations: Iterable[Explanation]) -> float:
        """Least cost of these explanations so far."""
        return min(self._done[e].cost for e in explanations)

    def _finish(self, explanations: Sequence[Explanation]) -> None:
        """Carries fits to the end."""
        if not explanations:
            return
        for e in explanations:
            self.progress(" + ".join(e.names) or "the rig as it is")
        ends = together([self._to_the_end(self._done[e]) for e in explanations])
        self._done |= zip(explanations, ends, strict=True)
        self._finished |= {*explanations}
        self._free_starts()

    def _begun(
        self, explanations: Sequence[Explanation], parent: Explanation
    ) -> tuple[dict[Explanation, Screened], dict[Explanation, list[Fit]]]:
        """Explanations as screened from a parent's estimates, and the places where each may begin, those that leave least
        first."""
        found = Screen(self(parent)).predict([self._candidate(e, parent) for e in explanations])
        screened = dict(zip(explanations, found, strict=True))
        places = [
            (e, replace(self._begin_at(e, parent, s), theta=theta)) for e, s in screened.items() for theta in s.begin
        ]
        begun: dict[Explanation, list[Fit]] = {e: [] for e in explanations}
        for (e, _), f in zip(places, together([placed(f) for _, f in places]), strict=True):
            same = any(abs(f.cost - other.cost) <= SAME * other.cost for other in begun[e])
            begun[e] += () if same else (f,)
        return screened, {e: sorted(fits, key=lambda f: f.cost) for e, fits in begun.items()}

    def search(self, explanation: Explanation, parent: Explanation) -> None:
        """One explanation on from all places where it may begin, the best of which a race may have left behind."""
        begun = self._begun([explanation], parent)[1][explanation]
        found = together([descend(f, most_steps=LONG, tolerance=TOLERANCE) for f in begun])
        best = sorted(found, key=lambda f: f.cost)[:BEGIN]
        self._keep({explanation: min(together([self._to_the_end(f) for f in best]), key=lambda f: f.cost)})

    def _begin_at(self, explanation: Explanation, parent: Explanation, screened: Screened) -> Fit:
        """An explanation as it stands where it was screened."""
        problem = self._of_training(structure_for(self.rig, explanation))
        c, _ = self._space(explanation)
        return point(problem, c, screened.theta, self._start(problem, self(parent)), screened.residual)

    def _keep(self, found: dict[Explanation, Fit]) -> None:
        """Takes down fits that are better than what is known, or that took steps where what is known did not."""
        for e, fitted in found.items():
            old = self._done.get(e)
            if old is None or fitted.cost <= old.cost or not old.steps:
                self._done[e] = fitted

    def _to_the_end(self, begun: Fit) -> Search[Fit]:
        """A fit carried to the end."""
        return _ended(self._of_training(begun.problem.structure), begun)

    def polish(self, explanation: Explanation) -> Fit:
        """The fit of an explanation to the last digit: by exact derivatives, then by secants, which see across the creases of
        stick and slip."""
        self.exactly([explanation])
        self._keep({explanation: together([self._polished(self(explanation), LAST_DIGIT)])[0]})
        return self._done[explanation]

    def exactly(self, explanations: Iterable[Explanation]) -> None:
        """Fits explanations on by exact derivatives through short windows that begin at what was measured: they go straight
        along a narrow valley where secants of whole runs creep, and find one that whole runs end before. Those whose readings
        reach back further than the windows are left as they are; once more where this frees the first states."""
        wanted = [
            e for e in dict.fromkeys(explanations) if self._exact.get(e) != self._ruled and self._within_windows(e)
        ]
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

    def _within_windows(self, explanation: Explanation) -> bool:
        return structure_for(self.rig, explanation).latest <= self.problem.structure.latest

    def _polished(self, begun: Fit, tolerance: float) -> Search[Fit]:
        return _carried_on(self._of_training(begun.problem.structure), begun, MOST_STEPS, tolerance)

    def _free_starts(self) -> None:
        """Frees the first states where the best finished fit is then complete: of all finished fits, and of all others whose
        misfit may come from their first states alone."""
        best = min((self._done[e] for e in self._finished), key=lambda f: f.cost)
        most = 0.5 * ONLY_STARTS * COMPLETE * best.problem.batch.readings
        if not self._ruled or best.cost > most:
            return
        self._of_training(best.problem.structure)
        if complete(together([_carried_on(self._training[best.problem.structure], best, FOLD_STEPS)])[0]):
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

    def on(self, explanation: Explanation, train: Sequence[int]) -> Search[Fit]:
        """Fit of an explanation to other logs than those marked for training, from its estimates on those."""
        begun = self(explanation)
        problem = self._posed(begun.problem.structure).only(train)
        start = np.where(problem.start_free, begun.start, problem.start)
        return _carried_on(problem.by_rule if self._ruled else problem, replace(begun, start=start), FOLD_STEPS)
