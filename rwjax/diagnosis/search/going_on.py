"""Going on: the search for what stands beside names that leave something, judged also by the runs that were left out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax.diagnosis.comparison_by_runs import ComparisonByRuns
from rwjax.diagnosis.exact_fits import fit_exactly
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.forward_backward import Search
from rwjax.diagnosis.search.neighbours import extensions
from rwjax.diagnosis.search.pairs import promising_pairs


class FurtherSearch(Search):
    """A search that goes on.

    Args:
        fits: where the fits are kept.
        candidates: names that might be missing.

    Attributes:
        by_runs: the comparison, which knows left-out runs.
        settled: the choice that no rival has surpassed so far, None before there is one.
    """

    def __init__(self, fits: ModelFits, candidates: Sequence[str]) -> None:
        self.by_runs = ComparisonByRuns(fits)
        super().__init__(fits, candidates, self.by_runs)
        self.settled: Choice | None = None

    def go_on(self, begin: Hypothesis) -> Choice:
        """Goes on from what was chosen, or from what was tried and leads in its place.

        What is negligible is measured by what the hypothesis leaves that is begun from. So this looks for what the search before it
        took for the exact form of its names. Where a visible part is left, two names are looked for at once, around the rig as it was first
        fitted and around its best fit, and a second name beside each of those that lead: the name that leaves least may stand in for two others.

        Args:
            begin: what was chosen, with a fit at its end.

        Returns:
            The choice, with what was tried.
        """
        begin = self._ahead(begin)
        forward = self.forward(begin, self.limits.most_names_further) if begin.names else begin
        best, rivals = self._settled(forward)
        self.settled = self.chosen(best, rivals)
        self.fits.headway.budget.keep(self.fits.settings.partial.kept)
        if self.comparison.leaves_visible(best):
            self.fit_pairs_around_the_first_fit()
            if (ahead := self._ahead(best)) != best:
                best, rivals = self._settled(ahead)
                self.settled = self.chosen(best, rivals)
        if self.comparison.leaves_visible(best):
            fit_exactly(self.fits, self._by_cost(self.pairs())[: self.limits.exactly_at_once])
            self._look_beside_leading_names(best)
            ahead = self._ahead(best)
            best, rivals = self.given_way(best) if ahead == best else self._settled(ahead)
        return self.chosen(best, rivals)

    def fit_pairs_around_the_first_fit(self) -> None:
        """Fits the pairs that are predicted to leave least around the rig as it was first fitted, where it is no longer as it was then.

        A search betters that fit by numbers that take up a part of what is missing, and hide the rest of it.
        """
        fits, now = self.fits, self.fits(NOTHING).theta
        with fits.as_first_fitted():
            moved = not np.array_equal(fits(NOTHING).theta, now)
            begun = promising_pairs(fits, self.candidates) if moved else {}
        problem = fits.training  # with first states as they are now
        pairs = self.fit_pairs(
            {e: [replace(f, problem=problem(f.problem.structure)) for f in places] for e, places in begun.items()}
        )
        fit_exactly(fits, self._by_cost(pairs)[: self.limits.exactly_at_once])

    def rivals(self, best: Hypothesis) -> list[Hypothesis]:
        """The rivals by exchange, and everything else of no more names that was tried.

        Args:
            best: the choice so far.

        Returns:
            The rivals; none where the choice removes so little that no name will stand.
        """
        rivals = super().rivals(best)
        return rivals and [*dict.fromkeys([*rivals, *self._tried(best, 1, len(best.names))])]

    def _settled(self, best: Hypothesis) -> tuple[Hypothesis, list[Hypothesis]]:
        """What no rival surpasses, from a larger set that was among the rivals where that is needed; and its rivals."""
        best, rivals = self.exchanged(best)
        ahead = self._ahead(best)
        return (best, rivals) if ahead == best else self.exchanged(ahead)

    def _ahead(self, best: Hypothesis) -> Hypothesis:
        """What was tried and leads in the place of a choice: a larger set that is needed, or one of no more names that surpasses it.

        Among the rivals of a law are larger sets, its special case beside another name, which no exchange of one name leads to.
        """
        compare, size = self.by_runs, len(best.names)
        larger = self._tried(best, size + 1, self.limits.most_names_further)
        needed = [e for e in larger if compare.in_sample.needs(e, best)]
        if needed and compare.needs(leader := self.backward(compare.leader(needed)), best):
            return leader
        return self.surpassing(best, self._tried(best, 1, size)) or best

    def _tried(self, best: Hypothesis, least: int, most: int) -> list[Hypothesis]:
        """The sets of so many names that were tried, but a choice and its parts."""
        fits = self.fits
        tried = [e for e in fits if least <= len(e.names) <= most and not {*e.names} <= {*best.names}]
        return [e for e in tried if fits.stepped(e) and np.isfinite(fits.known(e).cost)]

    def _look_beside_leading_names(self, best: Hypothesis) -> None:
        """Fits a second name beside the names that leave least alone, of a law and its special case the better one, and beside a single choice.

        Not where that was done with as good a fit of the first name, and not beside a name that leaves many times as much as the choice.
        """
        fits, leading = self.fits, [best] if len(best.names) == 1 else []
        most = self.limits.beginnings_leave * self.comparison.excess(best)
        for e in self._by_cost([e for e in self._tried(best, 1, 1) if self.comparison.excess(e) < most]):
            if not any(e.contains(other) or other.contains(e) for other in leading):
                leading.append(e)
        leading = leading[: self.limits.beginnings]
        fits.end(leading)
        beside: dict[Hypothesis, Hypothesis] = {}
        for number, e in enumerate(leading, 1):
            tried = extensions(self.candidates, e)
            if tried and not fits.fitted_from(e, tried):
                self.announce(tried, e, passes=len(leading) - number)
                fits.take_down(e, tried)
                self.halving.fit(tried, e)
                beside |= {one: e for one in tried if one not in beside}
        self._fit_leading_pairs_thoroughly(beside)

    def _fit_leading_pairs_thoroughly(self, beside: dict[Hypothesis, Hypothesis]) -> None:
        """Fits the pairs that leave least from all places beside their first name, until one comes near the noise.

        The place at which a second name began may not be its best, and then the pair is refused for what only this fit of it leaves.
        """
        enough = self.fits.settings.verdict.doubt**2
        for e in self._by_cost([*beside])[: self.limits.from_all_places[0]]:
            self._fit_from_all_places([e], beside[e], [*beside], enough)
