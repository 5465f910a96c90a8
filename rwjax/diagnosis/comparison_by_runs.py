"""ComparisonByRuns: the model comparison of a search that goes on, far above the noise, where the evidence takes all that is left for noise."""

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.left_out import LeftOut
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits


class ComparisonByRuns(ModelComparison):
    """Compares hypotheses also by the runs that they were not fitted to.

    Args:
        fits: the fits that are compared.

    Attributes:
        left_out: errors of hypotheses on runs that they were not fitted to.
    """

    def __init__(self, fits: ModelFits) -> None:
        super().__init__(fits, fits.settings.partial.further_removes)
        self.left_out = LeftOut(fits)
        self._in_sample = ModelComparison(fits, self.further_removes)

    @property
    def in_sample(self) -> ModelComparison:
        """The comparison by the runs that hypotheses were fitted to alone."""
        return self._in_sample

    def needs(self, larger: Hypothesis, smaller: Hypothesis) -> bool:
        """Whether the logs need the larger hypothesis in place of the smaller one, and follow left-out runs better with it.

        Args:
            larger: the hypothesis with more names, or others.
            smaller: the hypothesis with fewer names.

        Returns:
            True where they do.
        """
        return super().needs(larger, smaller) and (
            not self.left_out.runs or self.left_out.excess(larger) < self.left_out.excess(smaller)
        )

    def leaves_more(self, one: Hypothesis, other: Hypothesis) -> bool:
        """Whether a hypothesis leaves so much more than another one, of the runs that both are fitted to or of left-out ones.

        Args:
            one: a hypothesis.
            other: another one.

        Returns:
            True where the other one removes as much of what it leaves as a further name has to.
        """
        return super().leaves_more(one, other) or self._follows_worse(one, other)

    def first_of(self, hypotheses: list[Hypothesis], effective: dict[str, float]) -> Hypothesis:
        """The hypothesis with the best criterion of those that lead and leave no more than another one of them of the left-out runs.

        Args:
            hypotheses: those to choose from, at least one.
            effective: independent samples by output [1].

        Returns:
            The first.
        """
        if not self.left_out.runs:
            return super().first_of(hypotheses, effective)
        ahead = sorted(hypotheses, key=self.excess)[: self.limits.by_runs]
        self.left_out.prepare(ahead)
        least = min(ahead, key=self.left_out.excess)
        return max((e for e in ahead if not self._follows_worse(e, least)), key=lambda e: self.criterion(e, effective))

    def _follows_worse(self, one: Hypothesis, other: Hypothesis) -> bool:
        """Whether a hypothesis leaves more than twice as much as another one of the runs that they were not fitted to."""
        least = (1.0 - self.limits.further_removes) * self.left_out.excess(one)
        return max(self.left_out.excess(other), self.limits.nothing_left) < least
