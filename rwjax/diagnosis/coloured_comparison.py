r"""ColouredComparison: which of two hypotheses the training logs speak for, beside a remainder that is coloured noise.

What names leave that stand among much that is small is slow, above all where an angle piles up what each moment adds. Its squares have few
independent readings, so that half of them less says little. Each reading less what the ones before predict (`innovations`) tells more. With
the mean log likelihood $\ell$ of one of $n$ readings, a hypothesis with $k$ numbers and $f$ numbers of form gains over another one

$$ n\,(\ell_1 - \ell_2) - \tfrac12 (k_1 - k_2) \ln n - (f_1 - f_2), $$

less what the rig file's priors say against its numbers more than against the other's.
"""

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.innovations import log_likelihood
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.fitting.multiple_shooting import Fit


class ColouredComparison(ModelComparison):
    """Compares hypotheses as `ModelComparison` does, but for what one gains over another: by the likelihood of innovations.

    Args:
        fits: the fits that are compared.
        further_removes: share of the remaining excess that a further name must remove [1], that of the usual search where none is given.
    """

    def __init__(self, fits: ModelFits, further_removes: float | None = None) -> None:
        super().__init__(fits, further_removes)
        self._coloured: dict[Hypothesis, tuple[Fit, tuple[int, float]]] = {}

    def gain(self, larger: Hypothesis, smaller: Hypothesis) -> float:
        """Gain by the larger hypothesis in log evidence [1], where what both leave is an autoregression.

        Args:
            larger: the hypothesis with more names, or others.
            smaller: the hypothesis with fewer names.

        Returns:
            The gain [1]; minus infinity where a run of the larger one left the range of numbers.
        """
        count, more = self._likelihood(larger)
        _, less = self._likelihood(smaller)
        if not np.isfinite(more):
            return -np.inf
        (k_1, f_1), (k_2, f_2) = self._numbers(larger), self._numbers(smaller)
        numbers = 0.5 * (k_1 - k_2) * float(np.log(max(count, 1))) + (f_1 - f_2)
        return count * (more - less) - numbers - (self._against(larger) - self._against(smaller))

    def _against(self, hypothesis: Hypothesis) -> float:
        """What the rig file's priors say against a hypothesis's numbers [1]."""
        fitted = self.fits.known(hypothesis)
        return fitted.problem.prior_cost(fitted.theta)[0]

    def likelier(self, larger: Hypothesis, smaller: Hypothesis) -> bool:
        """Whether the larger hypothesis gains enough, altogether and by the reading: of many readings any difference of two models is likely.

        Args:
            larger: the hypothesis with more names, or others.
            smaller: the hypothesis with fewer names.

        Returns:
            True where it does.
        """
        if not self.gains_altogether(larger, smaller):
            return False
        count, _ = self._likelihood(larger)
        least = self.fits.settings.partial.needed_by_reading * count
        return not self._predicts(count) or self.gain(larger, smaller) > least

    def gains_altogether(self, larger: Hypothesis, smaller: Hypothesis) -> bool:
        """Whether the larger hypothesis gains enough altogether, and by its squares, too.

        A law with several numbers that follows a slow motion gains by what it bends at its edges, though the squares have too few independent
        readings for its numbers. Where most readings do not follow enough others, as between holes, the squares alone decide.

        Args:
            larger: the hypothesis with more names, or others.
            smaller: the hypothesis with fewer names.

        Returns:
            True where it does.
        """
        limits, squares = self.fits.settings.partial, self._gain_of_squares(larger, smaller)
        if not self._predicts(self._likelihood(larger)[0]):
            return squares > limits.needed_of_squares_alone
        return bool(self.gain(larger, smaller) > limits.needed and squares > limits.needed_of_squares)

    def _predicts(self, count: int) -> bool:
        """Whether so many readings, predicted from the ones before them, are most of them."""
        return bool(count >= self.fits.settings.partial.predicted * sum(self._count.values()))

    def _gain_of_squares(self, larger: Hypothesis, smaller: Hypothesis) -> float:
        """Gain in the information criterion [1], with the fewer independent readings of those that both residuals allow."""
        one, other = self.effective(larger), self.effective(smaller)
        effective = {name: min(one[name], other[name]) for name in one}
        return self.criterion(larger, effective) - self.criterion(smaller, effective)

    def _likelihood(self, hypothesis: Hypothesis) -> tuple[int, float]:
        """Number of innovations, and the mean of their log likelihood [1], of a hypothesis's best fit so far."""
        fitted = self.fits.known(hypothesis)
        if hypothesis not in self._coloured or self._coloured[hypothesis][0] is not fitted:
            found = log_likelihood(fitted, self.fits.train, self.fits.settings.partial.order)
            self._coloured[hypothesis] = fitted, found
        return self._coloured[hypothesis][1]
