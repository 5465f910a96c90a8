"""Successive halving: fits of many hypotheses side by side, of which only the promising ones take further steps.

In each round every hypothesis that is left takes a few steps from each of its places. The candidates with the lowest extrapolated
cost advance to the next round, which has fewer of them and more steps (Jamieson and Talwalkar, AISTATS 2016). The extrapolation
matters because a fit that begins far off may be on its way.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

import numpy as np

from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.exact_fits import fit_exactly
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.settings import PairSettings, Round
from rwjax.diagnosis.starting_points import Begun, begin
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.processes import Task
from rwjax.fitting.secant import descend, with_residual


def extrapolated_cost(cost: float, before: float, parent: float, at_parent: float) -> float:
    """Cost of a fit [1] if the next round, of twice the steps, brings it twice as far in proportion as the last one.

    A fit that began above the parent's cost and has come down to it has gained only what it leaves less than the parent. From afar,
    the way back to adding nothing looks steep.

    Args:
        cost: cost after the last round [1].
        before: cost before it [1].
        parent: cost of the parent [1].
        at_parent: relative distance to the parent's cost that counts as come down to it [1].

    Returns:
        The extrapolated cost [1].
    """
    begun = min(before, parent) if cost <= (1.0 + at_parent) * parent else before
    return cost * min(cost / begun, 1.0) ** 2 if 0.0 < begun < np.inf else cost


def _cost(one: Fit) -> float:
    return one.cost


class SuccessiveHalving:
    """Fits hypotheses side by side by successive halving.

    Attributes:
        fits: where the fits are kept.
        limits: limits of the halving.
    """

    def __init__(self, fits: ModelFits) -> None:
        self.fits = fits
        self.limits = fits.settings.halving

    def fit(self, hypotheses: Iterable[Hypothesis], parent: Hypothesis) -> dict[Hypothesis, Fit]:
        """Fits hypotheses from a parent's estimates.

        What comes close to the best after the last round is carried to its end. A hypothesis that fell behind earlier begins again,
        and so does a special case of the parent, which may know a better place. Where more hypotheses begin than the last round
        takes, the most promising one is carried to its end by exact derivatives.

        Args:
            hypotheses: those to fit.
            parent: the hypothesis from whose estimates they begin.

        Returns:
            The best fit of each so far, at its end where it is close to the best.
        """
        fits, last = self.fits, self.limits.rounds[-1]
        wanted = list(dict.fromkeys(hypotheses))
        if not wanted:
            return {}
        new = [e for e in wanted if not fits.ended(e) or parent.contains(e) or e.contains(parent)]
        promise = self._halve(dict.fromkeys(new, parent))
        least = fits.least((parent, *wanted))
        ahead = [e for e in sorted(new, key=promise.__getitem__) if promise[e] <= self.limits.close * least]
        ahead = ahead[: last.hypotheses]
        again = [e for e in new if fits.ended(e) and e not in ahead]  # what it knows may be a better place
        parts = [ahead[:1], ahead[1:] + again]  # how far the first one comes says which of the others may still win
        if len(new) > last.hypotheses and not any(fits.ended(e) for e in ahead[:1]):
            fit_exactly(fits, ahead[:1])
            parts = parts[1:] if any(fits.ended(e) for e in ahead[:1]) else parts
        for part in parts:
            least = fits.least((parent, *wanted))
            most = self.limits.behind * least
            fits.finish([e for e in part if promise[e] <= most or e in again or parent.contains(e)])
        fits.settle()
        return {e: fits.known(e) for e in wanted}

    def fit_each(self, parents: Mapping[Hypothesis, Hypothesis]) -> None:
        """Fits hypotheses side by side, each from the estimates of a parent of its own; none gives way to another one.

        Args:
            parents: the parent of each hypothesis to fit.
        """
        promise = self._halve(parents, give_way=False)
        least = {e: self.fits.least((e, parent)) for e, parent in parents.items()}
        self.fits.finish([e for e in parents if self.fits.ended(e) or promise[e] <= self.limits.close * least[e]])
        self.fits.settle()

    def fit_again(self, hypotheses: Sequence[Hypothesis], parent: Hypothesis) -> None:
        """Fits hypotheses from another parent's estimates, however far they have come from their own.

        One that comes further and is left behind has to be carried to its end again.

        Args:
            hypotheses: hypotheses with a fit that has begun.
            parent: the hypothesis from whose estimates they begin.
        """
        ended = self.fits.reopen(hypotheses)
        try:
            self.fit(hypotheses, parent)
        finally:
            self.fits.close_again(ended)

    def from_all_places(self, hypotheses: Sequence[Hypothesis], parent: Hypothesis) -> dict[Hypothesis, Fit]:
        """Fits of hypotheses from all places where they may begin, the best of which the rounds may have left behind.

        Args:
            hypotheses: those to fit, side by side.
            parent: the hypothesis from whose estimates they begin.

        Returns:
            The best fit of each; the store is left as it was.
        """
        limits, begun = self.limits, begin(self.fits, hypotheses, parent)
        places = {e: begun[e].places or [begun[e].here] for e in hypotheses}
        stepped = iter(self._stepped([f for e in hypotheses for f in places[e]], limits.thorough_steps))
        furthest = {e: sorted((next(stepped) for _ in places[e]), key=_cost)[: limits.places] for e in hypotheses}
        ends = iter(self.fits.ends_of([f for several in furthest.values() for f in several]))
        return {e: min((next(ends) for _ in several), key=_cost) for e, several in furthest.items()}

    def fit_at(self, places: Mapping[Hypothesis, Sequence[Fit]], limits: PairSettings) -> list[Hypothesis]:
        """Fits hypotheses from given points, and carries those to their end that come close to the best.

        Args:
            places: points without a step, by hypothesis.
            limits: how many steps are taken from all points, and how many further ones from where they have come furthest.

        Returns:
            The hypotheses of which a free run from one of the points ends.
        """
        fits, work = self.fits, self.fits.settings.headway.first_round * len(places)
        begun = [(e, place) for e, found in places.items() for place in found]
        at = fits.together([Task(place.problem, partial(with_residual, place)) for _, place in begun])
        finite = [(e, place) for (e, _), place in zip(begun, at, strict=True) if np.isfinite(place.cost)]
        those = [*dict.fromkeys(e for e, _ in finite)]
        ended = fits.reopen(those)
        try:
            found = self._stepped([place for _, place in finite], limits.steps, work)
            for (e, _), stepped in zip(finite, found, strict=True):
                fits.keep({e: stepped})
            further = self._stepped([fits.known(e) for e in those], limits.further_steps, work)
            fits.keep(dict(zip(those, further, strict=True)))
            for e in places:
                fits.headway.compare(e)
            most = self.limits.close * fits.least(fits)
            fits.finish([e for e in those if fits.known(e).cost <= most])
        finally:
            fits.close_again(ended)
        return those

    def _stepped(
        self,
        begun: Sequence[Fit],
        steps: int,
        work: float = 0.0,
        done: Callable[[int, Fit], None] = lambda number, found: None,
    ) -> list[Fit]:
        """Fits after some steps."""
        tolerance = self.fits.settings.fitting.tolerance
        searches = [Task(f.problem, partial(descend, f, most_steps=steps, tolerance=tolerance)) for f in begun]
        return self.fits.together(searches, work, done)

    def _halve(self, parents: Mapping[Hypothesis, Hypothesis], *, give_way: bool = True) -> dict[Hypothesis, float]:
        """Runs the rounds of hypotheses by their parents; returns the extrapolated cost of each."""
        fits, limits = self.fits, self.limits
        begun: dict[Hypothesis, Begun] = {}
        for parent in dict.fromkeys(parents.values()):
            begun |= begin(fits, [e for e in parents if parents[e] == parent], parent, limits.behind)
        best = {e: b.here for e, b in begun.items()}
        fits.keep({e: here for e, here in best.items() if not fits.stepped(e)})
        promise = {e: b.predicted for e, b in begun.items()}
        places = {e: b.places for e, b in begun.items() if b.places}
        for e in begun.keys() - places.keys():
            fits.headway.compare(e)
        # what has begun may still be on its way by the start rule; beside a complete parent there is no room far above it
        most = {e: np.inf if fits.by_start_rule else limits.behind * fits(parent).cost for e, parent in parents.items()}
        work = fits.settings.headway
        for one in limits.rounds:
            ahead = [e for e in places if promise[e] <= most[e] or one is limits.rounds[0] or parents[e].contains(e)]
            ahead = sorted(ahead, key=promise.__getitem__)[: one.hypotheses if give_way else None]
            share = work.first_round if one is limits.rounds[0] else work.later_round
            self._round(one, ahead, parents, places, best, promise, share * len(parents))
            fits.keep({e: best[e] for e in ahead})
        return promise

    def _stepped_as_far_as_can_be(self, runs: Sequence[tuple[Hypothesis, Fit]], steps: int, work: float) -> list[Fit]:
        """Fits after some steps, counted as they are done; where the budget ends, those that are done are kept."""
        fits, landed = self.fits, dict[int, Fit]()
        waiting = {e: {k for k, (other, _) in enumerate(runs) if other == e} for e, _ in runs}

        def done(number: int, found: Fit) -> None:
            e = runs[number][0]
            landed[number] = found
            fits.headway.lead(e, found)
            if waiting[e] <= {*landed}:
                fits.headway.compare(e)

        try:
            return self._stepped([f for _, f in runs], steps, work, done)
        except Stopped:
            for number, found in [*landed.items()]:
                fits.keep({runs[number][0]: found})
            raise

    def _round(
        self,
        one: Round,
        ahead: Sequence[Hypothesis],
        parents: Mapping[Hypothesis, Hypothesis],
        places: dict[Hypothesis, list[Fit]],
        best: dict[Hypothesis, Fit],
        promise: dict[Hypothesis, float],
        work: float,
    ) -> None:
        """Steps of one round; updates places, best fits and extrapolated costs of those that take part."""
        runs = [(e, f) for e in ahead for f in places[e][: self.limits.places]]
        found = self._stepped_as_far_as_can_be(runs, one.steps, work)
        for e in ahead:
            parent_cost = self.fits(parents[e]).cost
            pairs = [(f, before) for (other, before), f in zip(runs, found, strict=True) if other == e]
            best[e] = min((f for f, _ in pairs), key=lambda f: f.cost)
            promised = [
                extrapolated_cost(f.cost, before.cost, parent_cost, self.limits.at_parent) for f, before in pairs
            ]
            coming = pairs[int(np.argmin(promised))][0]
            promise[e] = min(promised)
            places[e] = [best[e]] if coming is best[e] else [best[e], coming]


def fitted(fits: ModelFits, hypothesis: Hypothesis) -> Fit:
    """Fit of a hypothesis carried to its end, begun from the rig as it is where no search has begun it.

    Args:
        fits: where the fits are kept.
        hypothesis: any hypothesis.

    Returns:
        The fit.
    """
    if hypothesis.names and not fits.stepped(hypothesis):
        SuccessiveHalving(fits).fit([hypothesis], NOTHING)
    return fits(hypothesis)
