"""Going on: the search for what stands beside a name that leaves a visible part, judged also by the runs that were left out."""

from collections.abc import Sequence

from rwjax.diagnosis.comparison_by_runs import ComparisonByRuns
from rwjax.diagnosis.exact_fits import fit_exactly
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.forward_backward import Search
from rwjax.diagnosis.search.neighbours import extensions


class FurtherSearch(Search):
    """A search that goes on.

    Args:
        fits: where the fits are kept.
        candidates: names that might be missing.

    Attributes:
        by_runs: the comparison, which knows left-out runs.
    """

    def __init__(self, fits: ModelFits, candidates: Sequence[str]) -> None:
        self.by_runs = ComparisonByRuns(fits)
        super().__init__(fits, candidates, self.by_runs)

    def go_on(self, begin: Hypothesis) -> Choice:
        """Goes on from what was chosen; where that leaves a visible part, from two names at once and from other names, too.

        What is negligible is measured by what the hypothesis leaves that is begun from. So this looks for what the search before it
        took for the exact form of its names. The name that leaves least may stand in for two others: a second name is looked for beside
        each of those that lead.

        Args:
            begin: what was chosen, with a fit at its end.

        Returns:
            The choice, with what was tried.
        """
        most = self.limits.most_names_further
        begin = self._led_by(begin)
        best, rivals = self._settled(self.forward(begin, most) if begin.names else begin)
        if self.comparison.leaves_visible(best):
            fit_exactly(self.fits, self._by_cost(self.pairs())[: self.limits.exactly_at_once])
            self._look_beside_leading_names()
            if (better := self._led_by(best)) != best:
                best, rivals = self._settled(better)
        return self.chosen(best, rivals)

    def _settled(self, best: Hypothesis) -> tuple[Hypothesis, list[Hypothesis]]:
        """What neither a rival surpasses nor, where it leaves a visible part, anything else that was tried; and its rivals."""
        best, rivals = self.exchanged(best)
        for _ in range(self.limits.exchanges):
            if not self.comparison.leaves_visible(best) or (better := self._led_by(best)) == best:
                break
            best, rivals = self.exchanged(better)
        return best, rivals

    def _look_beside_leading_names(self) -> None:
        """Fits a second name beside each of those that leave least alone, unless this was done with a fit of it as good."""
        fits = self.fits
        singles = [e for e in extensions(self.candidates, NOTHING) if fits.stepped(e)]
        for single in self._by_cost(singles)[: self.limits.beginnings]:
            if not fits.fitted_from(single, tried := extensions(self.candidates, single)):
                self.announce(tried, single)
                fits.take_down(single, tried)
                self.halving.fit(tried, single)

    def _led_by(self, best: Hypothesis) -> Hypothesis:
        """A choice, or what leads of all that was tried in its place where the choice leaves clearly more.

        Among the rivals of a name are larger sets: what it includes, beside another name. A search by exchanges alone passes these over.
        """
        most = max(self.limits.most_names_further, len(best.names))
        tried = [e for e in self.fits if 0 < len(e.names) <= most and e != best and self.fits.stepped(e)]
        compare = self.comparison
        if not tried:
            return best
        leader = self.backward(compare.leader(tried))
        return leader if compare.leaves_more(best, leader) and compare.needs(leader, NOTHING) else best
