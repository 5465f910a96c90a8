"""Refits: the rig's free numbers and an explanation's together, from several starts."""

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from rwjax.build import theta_of
from rwjax.diagnose.explanation import Explanation, free_names, space, structure_for
from rwjax.diagnose.screen import Candidate, Screen, Screened
from rwjax.fit.anchored import fit_anchored
from rwjax.fit.end_to_end import Fit, fit
from rwjax.fit.nodes import measured_nodes
from rwjax.fit.problem import Problem, pose
from rwjax.log import Log
from rwjax.noise import pooled
from rwjax.plant import Structure
from rwjax.rig import Rig

FIRST_STEPS = 6  # of every start; the best one then goes on
THREADS = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
HOPELESS = 4.0
"""Cost against the best one's above which an explanation that gets no nearer is not fitted to the end."""
PROMISING = 8
"""Explanations of a race that are fitted, those that the screen predicts to leave least; the others are only evaluated."""
NEARER = 1.5
"""Factor by which the cost must fall in `FIRST_STEPS` steps for an explanation to get nearer."""


def _further(begun: Fit) -> Fit:
    return fit(
        begun.problem,
        begun.coordinates,
        begun.theta,
        start=begun.start,
        damping=begun.damping,
        most_steps=FIRST_STEPS,
    )


def _roughly(begun: Fit) -> Fit:
    return fit_anchored(
        begun.problem,
        begun.coordinates,
        begun.theta,
        begun.start,
        damping=begun.damping,
        careful=False,
    )


@dataclass
class Refits:
    """Fits of explanations of one rig to the logs marked for training, each made once.

    `problem` holds all logs, so that a fit, a fold and a free run share one compiled program for each structure.
    """

    rig: Rig
    problem: Problem
    train: tuple[int, ...]
    progress: Callable[[str], None]
    _problems: dict[Structure, Problem] = field(default_factory=dict)
    _done: dict[Explanation, Fit] = field(default_factory=dict)
    _hopeless: set[Explanation] = field(default_factory=set)
    _polished: set[Explanation] = field(default_factory=set)

    @classmethod
    def of(cls, rig: Rig, logs: Sequence[Log], train: Sequence[int], progress: Callable[[str], None]) -> "Refits":
        """Refits of `rig` to `logs`, trained on those numbered in `train`."""
        noise = pooled(tuple(logs[k] for k in train))
        unseen = pooled(tuple(logs))  # for outputs that no training log holds
        return cls(
            rig, pose(structure_for(rig, Explanation()), logs, unseen | noise, prior=rig.prior), tuple(train), progress
        )

    def __call__(self, explanation: Explanation) -> Fit:
        """Best fit of an explanation."""
        if explanation not in self._done:
            begun = self._begin(explanation)
            self._done[explanation] = fit_anchored(begun.problem, begun.coordinates, begun.theta, begun.start)
        return self._done[explanation]

    def __contains__(self, explanation: Explanation) -> bool:
        return explanation in self._done

    def _begin(self, explanation: Explanation) -> Fit:
        """The start that the first few steps bring furthest."""
        self.progress(" + ".join(explanation.names) or "the rig as it is")
        problem = self.problem_of(explanation).only(self.train)
        coordinates, starts = space(self.rig, explanation, [self.problem.logs[k] for k in self.train])
        tried = [
            fit(problem, coordinates, start, nodes=nodes, most_steps=FIRST_STEPS)
            for start in starts
            for nodes in (measured_nodes(problem, start), None)
        ]
        return min(tried, key=lambda f: f.cost)

    def problem_of(self, explanation: Explanation) -> Problem:
        """All logs with the structure that an explanation needs."""
        structure = structure_for(self.rig, explanation)
        if structure not in self._problems:
            posed = pose(structure, self.problem.logs, self.problem.noise, prior=self.rig.prior)
            self._problems[structure] = posed
        return self._problems[structure]

    def _numbers(self, structure: Structure, fitted: Fit) -> np.ndarray:
        """Numbers of a fit in the order of another structure, what that has besides at its null."""
        values = fitted.numbers()
        return np.array([values.get(n, v) for n, v in zip(structure.names, theta_of(self.rig, structure), strict=True)])

    def _screened(self, explanation: Explanation, parent: Explanation, screen: Screen) -> Screened:
        """What an explanation promises from a parent's estimates, and where its search should begin."""
        problem = self.problem_of(explanation).only(self.train)
        structure = problem.structure
        moves, starts = space(self.rig, explanation, [self.problem.logs[k] for k in self.train])
        own = {*free_names(self.rig, explanation)}
        shared = {*free_names(self.rig, parent)} & own
        known = np.array([name in shared for name in structure.names])
        added = np.array([name in own - shared for name in structure.names])
        null = theta_of(self.rig, structure)
        bases = [np.where(known, self._numbers(structure, self(parent)), start) for start in starts]
        bounds = np.tile([-np.inf, np.inf], (len(null), 1))
        bounds[moves.index] = moves.bounds
        return screen.predict(Candidate(problem, np.where(added, null, bases[0]), bases, added & (null == 0.0), bounds))

    def _glance(self, explanation: Explanation, parent: Explanation, theta: np.ndarray) -> Fit:
        """An explanation as it stands at a screened start."""
        problem = self.problem_of(explanation).only(self.train)
        coordinates, _ = space(self.rig, explanation, [self.problem.logs[k] for k in self.train])
        return fit(problem, coordinates, theta, start=self._start(problem, self(parent)), most_steps=0)

    def _start(self, problem: Problem, fitted: Fit) -> np.ndarray:
        """First states of a fit in another structure's order."""
        start = problem.start.copy()
        for k, name in enumerate(fitted.problem.structure.states):
            start[:, problem.structure.states.index(name)] = fitted.start[:, k]
        return start

    def _from(self, explanation: Explanation, parent: Explanation, theta: np.ndarray) -> Fit:
        """The first few steps of an explanation from a screened start, through short windows and without."""
        self.progress(" + ".join(explanation.names))
        problem = self.problem_of(explanation).only(self.train)
        coordinates, _ = space(self.rig, explanation, [self.problem.logs[k] for k in self.train])
        first = self._start(problem, self(parent))
        tried = [
            fit(problem, coordinates, theta, start=first, nodes=nodes, most_steps=FIRST_STEPS)
            for nodes in ((None,) if explanation in self else (measured_nodes(problem, theta), None))
        ]
        return min(tried, key=lambda f: f.cost)

    def race(self, explanations: Iterable[Explanation], parent: Explanation) -> dict[Explanation, Fit]:
        """Fits of several explanations side by side, from a parent's estimates.

        One that leaves more than `HOPELESS` times what the best one leaves, and gets no nearer, is not fitted to the
        end; it may run again in another race. So does a special case of the parent, which may know a better place.
        """
        wanted = list(dict.fromkeys(explanations))
        self(parent)
        screen = Screen(self(parent))
        with ThreadPoolExecutor(THREADS) as pool:
            new = [e for e in wanted if e not in self._done or e in self._hopeless or parent.contains(e)]
            screened = dict(zip(new, pool.map(lambda e: self._screened(e, parent, screen), new), strict=True))
            promising = sorted(new, key=lambda e: screened[e].left)
            begun = pool.map(lambda e: self._from(e, parent, screened[e].theta), promising[:PROMISING])
            left = dict(zip(promising[:PROMISING], begun, strict=True))
            for e in promising[PROMISING:]:
                if e not in self._done:
                    self._done[e] = self._glance(e, parent, screened[e].theta)
                    self._hopeless.add(e)
            done = {e: self._done[e] for e in wanted if e not in left}
            moving = set(left)
            while left:
                least = min(f.cost for f in (self(parent), *left.values(), *done.values()))
                if near := [e for e in left if left[e].cost <= HOPELESS * least]:
                    done |= zip(near, pool.map(_roughly, [left.pop(e) for e in near]), strict=True)
                elif moving := [e for e in left if e in moving]:
                    for e, fitted in zip(moving, pool.map(_further, [left[e] for e in moving]), strict=True):
                        if fitted.cost > left[e].cost / NEARER:
                            moving = [other for other in moving if other != e]
                        left[e] = fitted
                else:
                    break
        for e, fitted in (done | left).items():
            if e not in self._done or fitted.cost < self._done[e].cost:
                self._done[e] = fitted
                (self._hopeless.add if e in left else self._hopeless.discard)(e)
        return {e: self._done[e] for e in wanted}

    def polish(self, explanation: Explanation) -> Fit:
        """The fit of an explanation, gone on with across the creases of stick and slip; kept where that is better."""
        begun = self(explanation)
        if explanation not in self._polished:
            self._polished.add(explanation)
            self.progress(f"{' + '.join(explanation.names)}, more closely")
            problem = self.problem_of(explanation).only(self.train)
            found = fit_anchored(problem, begun.coordinates, begun.theta, begun.start)
            if found.cost < begun.cost:
                self._done[explanation] = begun = found
        return begun

    def on(self, explanation: Explanation, train: Sequence[int]) -> Fit:
        """Fit of an explanation to other logs than those marked for training, from its estimates on those."""
        begun = self(explanation)
        problem = self.problem_of(explanation).only(train)
        start = np.where(problem.start_free, begun.start, problem.start)
        return fit_anchored(problem, begun.coordinates, begun.theta, start)
