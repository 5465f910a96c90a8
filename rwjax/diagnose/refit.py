"""Refits: the rig's free numbers and an explanation's together, from several starts."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from threading import Lock

import numpy as np

from rwjax.diagnose.explanation import Explanation, space, structure_for
from rwjax.fit.anchored import fit_anchored
from rwjax.fit.end_to_end import Fit, fit
from rwjax.fit.nodes import measured_nodes
from rwjax.fit.problem import Problem, pose
from rwjax.log import Log
from rwjax.rig import Rig

FIRST_STEPS = 6  # of every start; the best one then goes on
THREADS = 2


@dataclass
class Refits:
    """Fits of explanations of one rig to the logs marked for training, each made once.

    `problem` holds all logs, so that a fit, a fold and a free run share one compiled program for each structure.
    """

    rig: Rig
    problem: Problem
    train: tuple[int, ...]
    progress: Callable[[str], None]
    _done: dict[Explanation, Fit] = field(default_factory=dict)
    _polished: set[Explanation] = field(default_factory=set)
    _lock: Lock = field(default_factory=Lock)

    @classmethod
    def of(cls, rig: Rig, logs: Sequence[Log], train: Sequence[int], progress: Callable[[str], None]) -> "Refits":
        """Refits of `rig` to `logs`, trained on those numbered in `train`."""
        return cls(rig, pose(structure_for(rig), logs), tuple(train), progress)

    def __call__(self, explanation: Explanation, parent: Explanation | None = None) -> Fit:
        """Best fit of an explanation; with a `parent` its estimates are where the search begins."""
        with self._lock:
            known = self._done.get(explanation)
        if known is not None:
            return known
        best = self._search(explanation, parent)
        with self._lock:
            self._done[explanation] = best
        self.progress(" + ".join(explanation.names) or "the rig as it is")
        return best

    def _search(self, explanation: Explanation, parent: Explanation | None) -> Fit:
        problem = self.problem.only(self.train)
        coordinates, starts = space(self.rig, explanation, [self.problem.logs[k] for k in self.train])
        if parent is None:
            first = [
                fit(problem, coordinates, start, nodes=nodes, most_steps=FIRST_STEPS)
                for start in starts
                for nodes in (measured_nodes(problem, start), None)
            ]
        else:
            begun = self._done[parent]
            shared = {*self.rig.free, *({*explanation.numbers} & {*parent.numbers})}
            prefixes = tuple(f"{effect}." for effect in explanation.effects if effect in parent.effects)
            known = np.array(
                [
                    name in shared or (name.startswith(prefixes) if prefixes else False)
                    for name in problem.structure.names
                ]
            )
            first = [
                fit(
                    problem,
                    coordinates,
                    np.where(known, begun.theta, start),
                    start=begun.start,
                    most_steps=FIRST_STEPS,
                )
                for start in starts
            ]
        best = min(first, key=lambda f: f.cost)
        return fit_anchored(problem, coordinates, best.theta, best.start, careful=parent is None)

    def many(self, explanations: Iterable[Explanation], parent: Explanation | None = None) -> dict[Explanation, Fit]:
        """Fits of several explanations, side by side."""
        wanted = list(dict.fromkeys(explanations))
        with ThreadPoolExecutor(THREADS) as pool:
            return dict(zip(wanted, pool.map(lambda e: self(e, parent), wanted), strict=True))

    def polish(self, explanation: Explanation) -> Fit:
        """The fit of an explanation, gone on with across the creases of stick and slip; kept where that is better."""
        begun = self(explanation)
        if explanation not in self._polished:
            self._polished.add(explanation)
            problem = self.problem.only(self.train)
            found = fit_anchored(problem, begun.coordinates, begun.theta, begun.start)
            if found.cost < begun.cost:
                self._done[explanation] = begun = found
        return begun

    def on(self, explanation: Explanation, train: Sequence[int]) -> Fit:
        """Fit of an explanation to other logs than those marked for training, from its estimates on those."""
        begun = self(explanation)
        problem = self.problem.only(train)
        start = np.where(problem.start_free, begun.start, problem.start)
        return fit_anchored(problem, begun.coordinates, begun.theta, start)
