"""Model comparison: which of two hypotheses the training logs speak for, and how much error each one leaves."""

import numpy as np

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis, free_names
from rwjax.diagnosis.information_criterion import effective_samples, information_criterion, residuals, sums_of_squares
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.effects.library import null_of_optional
from rwjax.fitting.multiple_shooting import Fit


class ModelComparison:
    """Compares hypotheses by their fits to the training logs, as far as these have come.

    Attributes:
        fits: the fits that are compared.
        limits: limits of the search.
        further_removes: share of the remaining excess that a further name must remove [1].
        in_sample: the comparison by the fitted runs alone.
    """

    def __init__(self, fits: ModelFits, further_removes: float | None = None) -> None:
        self.fits = fits
        self.limits = fits.settings.search
        self.in_sample: ModelComparison = self
        self.further_removes = self.limits.further_removes if further_removes is None else further_removes
        self._squares: dict[Hypothesis, tuple[Fit, dict[str, float]]] = {}
        self._effective: dict[Hypothesis, tuple[Fit, dict[str, float]]] = {}
        self._count: dict[str, float] = {}

    @property
    def compared(self) -> tuple[Hypothesis, ...]:
        """Every hypothesis that was looked at, the first one first."""
        return tuple(self._squares)

    def _seen(self, hypothesis: Hypothesis) -> dict[str, float]:
        """Sum of squares by output of a hypothesis's best fit so far."""
        fitted = self.fits.known(hypothesis)
        if hypothesis not in self._squares or self._squares[hypothesis][0] is not fitted:
            self._squares[hypothesis] = fitted, sums_of_squares(residuals(fitted, self.fits.train))
            batch = fitted.problem.batch
            share = np.where(batch.weight > 0.0, batch.share, 0.0).sum(axis=(0, 1, 2))
            self._count = dict(zip(fitted.problem.structure.outputs, share, strict=True))
        return self._squares[hypothesis][1]

    def _numbers(self, hypothesis: Hypothesis) -> tuple[int, int]:
        """How many numbers of its own a hypothesis has, and how many of its effects' forms."""
        own = free_names(self.fits.rig, hypothesis, self.fits.outputs)[len(self.fits.rig.free) :]
        form = sum(null_of_optional(name) is not None for name in own)
        return len(own) - form, form

    def effective(self, hypothesis: Hypothesis) -> dict[str, float]:
        """Independent samples of a hypothesis's residual by output [1].

        Args:
            hypothesis: the hypothesis.

        Returns:
            Number of independent samples by output [1].
        """
        fitted = self.fits.known(hypothesis)
        if hypothesis not in self._effective or self._effective[hypothesis][0] is not fitted:
            self._effective[hypothesis] = fitted, effective_samples(residuals(fitted, self.fits.train))
        return self._effective[hypothesis][1]

    def criterion(self, hypothesis: Hypothesis, effective: dict[str, float]) -> float:
        """Information criterion of a hypothesis [1], less what the rig file's priors say against its numbers.

        Args:
            hypothesis: the hypothesis.
            effective: independent samples by output [1], the same for all that are compared.

        Returns:
            The criterion [1]; larger is better.
        """
        fitted = self.fits.known(hypothesis)
        against, _ = fitted.problem.prior_cost(fitted.theta)
        return information_criterion(self._seen(hypothesis), *self._numbers(hypothesis), effective) - against

    def gain(self, larger: Hypothesis, smaller: Hypothesis) -> float:
        """Gain in the information criterion by the larger hypothesis [1], with the effective samples of its residual.

        Args:
            larger: the hypothesis with more names.
            smaller: the hypothesis with fewer names.

        Returns:
            Criterion of the larger less that of the smaller [1].
        """
        effective = self.effective(larger)
        return self.criterion(larger, effective) - self.criterion(smaller, effective)

    def excess(self, hypothesis: Hypothesis) -> float:
        """Mean square of the residual above the noise [1], in units of the noise, summed over outputs.

        Args:
            hypothesis: the hypothesis.

        Returns:
            The excess [1], 0 where the noise is reached.
        """
        squares = self._seen(hypothesis)
        return sum(max(squares[name] / self._count[name] - 1.0, 0.0) for name in squares)

    def apart(self, one: Hypothesis, other: Hypothesis) -> float:
        """How far apart the motions of two hypotheses are.

        Args:
            one: a hypothesis.
            other: another one.

        Returns:
            Mean square of the difference [1], in units of the noise, of the output where it is largest.
        """
        of_one, of_other = (residuals(self.fits.known(e), self.fits.train) for e in (one, other))
        self._seen(one)  # which counts the readings
        return max(
            sum(float(np.sum((a - b) ** 2)) for a, b in zip(of_one[y], of_other[y], strict=True)) / self._count[y]
            for y in of_one
        )

    def removed(self, hypothesis: Hypothesis) -> float:
        """Share [1] of the rig's own error above the noise that a hypothesis removes from the training logs.

        Args:
            hypothesis: the hypothesis.

        Returns:
            The share [1] of the output where it is largest.
        """
        return max(self._removed(hypothesis).values(), default=1.0)

    def _removed(self, hypothesis: Hypothesis) -> dict[str, float]:
        """The same share [1] of each output in which the rig's own error stands above the noise."""
        whole, left = self._seen(NOTHING), self._seen(hypothesis)
        error = {y: [np.sqrt(max(s[y] / self._count[y], 1.0)) for s in (whole, left)] for y in whole}
        return {
            y: (a - b) / (a - 1.0) if np.isfinite(a) else float(np.isfinite(b))
            for y, (a, b) in error.items()
            if a > 1.0
        }

    def leaves_visible(self, hypothesis: Hypothesis) -> bool:
        """Whether a hypothesis leaves a visible part of the training runs.

        Args:
            hypothesis: the hypothesis.

        Returns:
            True where it is as large as a gap that is looked into, and no small share of the error of an output that is so large.
        """
        limits, left = self.fits.settings.verdict, self._seen(hypothesis)
        removed, far = self._removed(hypothesis), [y for y in left if left[y] / self._count[y] - 1.0 >= limits.doubt**2]
        least = min(removed.get(y, 0.0) for y in far) if far else max(removed.values(), default=1.0)
        return bool(np.sqrt(self.excess(hypothesis)) >= limits.doubt and least < limits.several)

    def leaves_something(self, hypothesis: Hypothesis) -> bool:
        """Whether a hypothesis leaves something of the training runs that a further name might explain, however little.

        Args:
            hypothesis: the hypothesis.

        Returns:
            True where it does.
        """
        return bool(self.excess(hypothesis) > self.limits.nothing_left)

    def needs(self, larger: Hypothesis, smaller: Hypothesis) -> bool:
        """Whether the logs need the larger hypothesis in place of the smaller one.

        Args:
            larger: the hypothesis with more names, or others.
            smaller: the hypothesis with fewer names.

        Returns:
            True where it gains enough in the criterion and removes enough of the excess; of a richer law in its place, half.
        """
        further = len(larger.names) > len(smaller.names)
        first = not smaller.names and len(larger.names) == 1
        worth = self.further_removes if further else self.limits.further_removes
        worth = self.limits.first_removes if first else worth
        removes = self.excess(larger) < (1.0 - worth) * self.excess(smaller)
        return bool(removes and self.likelier(larger, smaller))

    def likelier(self, larger: Hypothesis, smaller: Hypothesis) -> bool:
        """Whether the larger hypothesis gains enough in the criterion.

        Args:
            larger: the hypothesis with more names, or others.
            smaller: the hypothesis with fewer names.

        Returns:
            True where it does.
        """
        return self.gain(larger, smaller) > self.limits.needed

    def ties(self, one: Hypothesis, other: Hypothesis) -> bool:
        """Whether `other` leaves hardly more than `one` where even `one` does not reach the noise.

        Outputs that reach the noise tell hypotheses apart by their evidence. Of the others it would take all that is left for noise.

        Args:
            one: a hypothesis.
            other: another one.

        Returns:
            True where `one` is incomplete, and neither these outputs nor those tell the two apart.
        """
        a, b, limits = self._seen(one), self._seen(other), self.limits
        incomplete = [name for name in a if a[name] > limits.incomplete * self._count[name]]
        if not incomplete or any(
            b[name] - self._count[name] >= (1.0 + limits.tie) * (a[name] - self._count[name]) for name in incomplete
        ):
            return False
        told = {name: n for name, n in self.effective(one).items() if name not in incomplete}
        if not told:
            return True
        sides = ((one, a), (other, b))
        of_one, of_other = (information_criterion({n: s[n] for n in told}, *self._numbers(e), told) for e, s in sides)
        return of_other > of_one - limits.close

    def leaves_more(self, one: Hypothesis, other: Hypothesis) -> bool:
        """Whether a hypothesis leaves so much more than another one that the other's names are missing besides, whatever the evidence says.

        An output near the noise has thousands of independent readings, and one far above it a few. So what explains a little of the first
        has more evidence than what explains most of the second.

        Args:
            one: a hypothesis.
            other: another one.

        Returns:
            True where the other one removes as much of what it leaves as a further name has to.
        """
        least = (1.0 - self.limits.further_removes) * self.excess(one)
        return bool(max(self.excess(other), self.limits.nothing_left) < least)

    def abreast(self, hypotheses: list[Hypothesis]) -> list[Hypothesis]:
        """Hypotheses of which one may lead, as far as something besides the fitted runs speaks against others.

        Args:
            hypotheses: at least one.

        Returns:
            All of them.
        """
        return hypotheses

    def first_of(self, hypotheses: list[Hypothesis], effective: dict[str, float]) -> Hypothesis:
        """The hypothesis with the best criterion of those that do not leave more than another one (`leaves_more`).

        Args:
            hypotheses: those to choose from, at least one.
            effective: independent samples by output [1].

        Returns:
            The first.
        """
        able = self.abreast(hypotheses)
        least = min(able, key=self.excess)
        ahead = (e for e in able if not self.leaves_more(e, least))
        return max(ahead, key=lambda e: self.criterion(e, effective))

    def leader(self, hypotheses: list[Hypothesis]) -> Hypothesis:
        """The hypothesis with the best criterion of those that leave least, or a special case of it in whose place the logs do not need it.

        Something small besides lets a larger hypothesis gain a little beside its special case, mostly with numbers at their bounds.

        Args:
            hypotheses: those to choose from, at least one.

        Returns:
            The leader.
        """
        effective = self.effective(min(hypotheses, key=lambda e: self.fits.known(e).cost))
        best = self.first_of(hypotheses, effective)
        simpler = [e for e in hypotheses if best.contains(e) and not self.needs(best, e)]
        return max(simpler, key=lambda e: self.criterion(e, effective), default=best)

    def probabilities(
        self, hypotheses: list[Hypothesis], effective: dict[str, float]
    ) -> tuple[tuple[Hypothesis, float], ...]:
        """Probabilities of hypotheses among themselves [1], each as likely as another beforehand.

        Args:
            hypotheses: those to compare, at least one.
            effective: independent samples by output [1].

        Returns:
            Each hypothesis with its probability [1], the most probable first.
        """
        values = np.array([self.criterion(e, effective) for e in hypotheses])
        share = np.exp(values - values.max())
        share /= share.sum()
        order = np.argsort(-values, kind="stable")
        return tuple((hypotheses[k], float(share[k])) for k in order)
