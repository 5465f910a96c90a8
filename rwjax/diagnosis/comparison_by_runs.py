"""ComparisonByRuns: hypotheses compared also by the runs that they were not fitted to, where a search goes on."""

from rwjax.diagnosis.coloured_comparison import ColouredComparison
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.left_out import LeftOut
from rwjax.diagnosis.model_fits import ModelFits


class ComparisonByRuns(ColouredComparison):
    """Compares hypotheses by left-out runs first where these decide clearly, else by the fitted ones. It carries their fits to the end.

    Args:
        fits: the fits that are compared.

    Attributes:
        left_out: errors of hypotheses on runs that they were not fitted to.
    """

    def __init__(self, fits: ModelFits) -> None:
        super().__init__(fits, fits.settings.partial.further_removes)
        self.left_out = LeftOut(fits)
        self.in_sample: ColouredComparison = ColouredComparison(fits, self.further_removes)

    def needs(self, larger: Hypothesis, smaller: Hypothesis) -> bool:
        """Whether the logs need the larger hypothesis in place of the smaller one, and left-out runs are followed better with it.

        Args:
            larger: the hypothesis with more names, or others.
            smaller: the hypothesis with fewer names.

        Returns:
            True where they do.
        """
        self.left_out.prepare([larger, smaller])
        return super().needs(larger, smaller) and self.follows_better(larger, smaller)

    def likelier(self, larger: Hypothesis, smaller: Hypothesis) -> bool:
        """Whether the larger hypothesis gains enough; of a further name that removes most of left-out runs a small gain by the reading is enough.

        Args:
            larger: the hypothesis with more names, or others, with a fit at its end.
            smaller: the hypothesis with fewer names, with a fit at its end.

        Returns:
            True where it does.
        """
        if super().likelier(larger, smaller):
            return True
        if not len(larger.names) > len(smaller.names) > 0:
            return False
        left, without = self.left_out.excess(larger), self.left_out.excess(smaller)
        most = without > self.limits.nothing_left and left < self.fits.settings.partial.mostly * without
        return most and self.gains_altogether(larger, smaller)

    def follows_better(self, one: Hypothesis, other: Hypothesis) -> bool:
        """Whether a hypothesis follows left-out runs better than another one, or down to their noise.

        Args:
            one: a hypothesis.
            other: another one.

        Returns:
            True where it does, or where no run can be left out.
        """
        left = self.left_out.excess(one)
        return left <= self.limits.nothing_left or left < self.left_out.excess(other)

    def follows_worse(self, one: Hypothesis, other: Hypothesis) -> bool:
        """Whether a hypothesis leaves so much more of left-out runs than another one that the other's names are missing besides.

        Args:
            one: a hypothesis.
            other: another one.

        Returns:
            True where the other one removes as much of it as a further name has to.
        """
        least = (1.0 - self.limits.further_removes) * self.left_out.excess(one)
        return max(self.left_out.excess(other), self.limits.nothing_left) < least

    def leaves_more(self, one: Hypothesis, other: Hypothesis) -> bool:
        """Whether a hypothesis leaves so much more than another one that the other's names are missing besides, whatever the evidence says.

        Args:
            one: a hypothesis.
            other: another one.

        Returns:
            True where it does by left-out runs; where these do not decide either way, by the fitted ones.
        """
        if self.follows_worse(one, other) or self.follows_worse(other, one):
            return self.follows_worse(one, other)
        return super().leaves_more(one, other)

    def abreast(self, hypotheses: list[Hypothesis]) -> list[Hypothesis]:
        """Of the hypotheses that leave least of the fitted runs those that follow left-out runs about as well as the best of them.

        Args:
            hypotheses: at least one.

        Returns:
            Those of which one may lead, at least one.
        """
        ahead = sorted(hypotheses, key=self.excess)[: self.fits.settings.partial.by_runs]
        self.left_out.prepare(ahead)
        least = min(ahead, key=self.left_out.excess)
        return [e for e in ahead if not self.follows_worse(e, least)]
