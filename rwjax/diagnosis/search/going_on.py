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
        """Goes on from what was chosen, and looks for two names at once where a visible part is left.

        What is negligible is measured by what the hypothesis leaves that is begun from. So this looks for what the search before it
        took for the exact form of its names. Where something else that was tried follows the left-out runs clearly better, it is begun
        from that.

        Args:
            begin: what was chosen, with a fit at its end.

        Returns:
            The choice, with what was tried.
        """
        begin = self._followed(begin)
        best, rivals = self.exchanged(self.forward(begin, self.limits.most_names_further) if begin.names else begin)
        while self.comparison.leaves_visible(best) and (better := self._followed(best)) != best:
            best, rivals = self.exchanged(better)
        if (pair := self.pair(best)) is not None:
            best, rivals = self.exchanged(pair)
        return self.chosen(best, rivals)

    def pair(self, best: Hypothesis) -> Hypothesis | None:
        """Two names that explain together what one name after the other does not.

        Args:
            best: what the search has come to that adds one name after the other.

        Returns:
            The pair, or None where that leaves no visible part or no pair explains enough of it.
        """
        compare = self.comparison
        if not compare.leaves_visible(best) or not (pairs := self.pairs()):
            return None
        fit_exactly(self.fits, self._by_cost(pairs)[: self.limits.exactly_at_once])
        leader = compare.leader(pairs)
        return leader if compare.needs(leader, best) else None

    def _followed(self, best: Hypothesis) -> Hypothesis:
        """A choice, or what leads of all that was tried in its place where that follows left-out runs clearly better.

        Among the rivals of a name are larger sets: what it includes, beside another name. A search by exchanges alone passes these over.
        """
        most = max(self.limits.most_names_further, len(best.names))
        tried = [e for e in self.fits if 0 < len(e.names) <= most and e != best and self.fits.stepped(e)]
        if not best.names or not tried:
            return best
        leader = self.comparison.leader(tried)
        return leader if self.by_runs.follows_worse(best, leader) else best
