"""Judged: hypotheses by their errors on held-out logs, each worked out once."""

from collections.abc import Sequence

from rwjax.diagnosis.gap import Gap, HeldOut, gap, held_out
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.layout import Layout
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.successive_halving import fitted
from rwjax.diagnosis.waterfall import Rung, rung


class Judged:
    """Held-out errors of hypotheses.

    Attributes:
        fits: where the fits are kept.
        layout: which logs are fitted and which are held out.
        before: errors of the rig as it is, with their floor.
        signal: the headline signal.
    """

    def __init__(self, fits: ModelFits, layout: Layout, before: HeldOut, signal: str) -> None:
        self.fits, self.layout, self.before, self.signal = fits, layout, before, signal
        self._known: dict[Hypothesis, HeldOut] = {}

    def __call__(self, hypothesis: Hypothesis) -> HeldOut:
        """Errors of a hypothesis.

        Args:
            hypothesis: any hypothesis; one that no search has begun is fitted.

        Returns:
            The errors.
        """
        self.prepare([hypothesis])
        return self._known[hypothesis] if hypothesis.names else self.before

    def prepare(self, hypotheses: Sequence[Hypothesis]) -> None:
        """Works out the errors of several hypotheses side by side.

        Args:
            hypotheses: the hypotheses.
        """
        if not (new := [e for e in hypotheses if e.names and e not in self._known]):
            return
        self.fits.end([e for e in new if self.fits.stepped(e)])
        for e in new:
            fitted(self.fits, e)
        self._known |= zip(new, held_out(self.fits, new, self.layout.folds, with_floor=False), strict=True)

    def anew(self) -> "Judged":
        """The same after a search, by which fits may have become better.

        Returns:
            The errors, none of them worked out but those of the rig as it is.
        """
        return Judged(self.fits, self.layout, errors_of_the_rig(self.fits, self.layout), self.signal)

    def rms(self, hypothesis: Hypothesis) -> float:
        """Error of the headline signal.

        Args:
            hypothesis: the hypothesis.

        Returns:
            The root of its mean square [SI].
        """
        return self(hypothesis).rms(self.signal)

    def rung(self, hypothesis: Hypothesis, base: dict[str, tuple[float, float]] | None = None) -> Rung:
        """The step of the waterfall at which a hypothesis stands.

        Args:
            hypothesis: the hypothesis.
            base: numbers of the rig as it is with their standard errors, from which shifts are counted; none for the rig as it is.

        Returns:
            The step.
        """
        rms = self.rms(hypothesis)  # which fits it where no search has begun it
        return rung(self.fits.rig, hypothesis.names, self.fits(hypothesis), rms, base)

    def gap_of(self, hypothesis: Hypothesis) -> Gap:
        """Gap of the headline signal.

        Args:
            hypothesis: the hypothesis that closes it.

        Returns:
            The gap.
        """
        return gap(self.before, self(hypothesis), self.signal, self.fits.settings.gap)

    def gaps(self, after: HeldOut) -> dict[str, Gap]:
        """Gap of every output.

        Args:
            after: errors with what is named.

        Returns:
            The gap by output.
        """
        limits = self.fits.settings.gap
        return {name: gap(self.before, after, name, limits) for name in self.before.square}


def errors_of_the_rig(fits: ModelFits, layout: Layout) -> HeldOut:
    """Errors of the rig as it is on held-out logs, with their floor.

    Args:
        fits: the rig's fits.
        layout: which logs are fitted and which are held out.

    Returns:
        The errors.
    """
    return held_out(fits, [NOTHING], layout.folds, with_floor=True)[0]
