"""Which: the smallest set of effects that explains the training logs, and every other set that does so as well.

Forward: the candidate with the most evidence is added while it is needed. Backward: a name that is not needed is
dropped again. Then every member is exchanged for every other candidate: a set whose evidence comes close, or that ties
where nothing reaches the noise, cannot be told apart from the best one on these logs; nor can what is declared to be the
same thing for the kind of rig.
"""

from dataclasses import dataclass

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis, candidates, free_names
from rwjax.diagnosis.information_criterion import effective_samples, log_evidence, residuals, sums
from rwjax.diagnosis.model_fits import BEHIND, ModelFits
from rwjax.diagnosis.search.equivalents import equivalents
from rwjax.diagnosis.settings import (
    CLOSE,
    CLOSE_ABOVE,
    FAR_FROM_NOISE,
    HOPEFUL,
    HOPELESS,
    MOST_NAMES,
    NEEDED,
    NOTHING_LEFT,
    NOTHING_NAMED,
    TIE,
    TRIFLE,
    WORTH,
    WORTH_BESIDES,
)
from rwjax.effects.library import brought_by, null_of_optional
from rwjax.fitting.multiple_shooting import Fit

LEADING, CLOSE_COST = 3, 1.5
"""Explanations at most from which their special cases are fitted, and their cost against the least."""
SEARCHED = (3, 1, 1)
"""Explanations that a race left ahead, beside so many names, and that are searched from all of their places where none of
them suffices."""
MANY = 5
"""Places from which an hypothesis may begin that count as many."""
EXACT = (6, 3, 3)
"""The same that are fitted on by exact derivatives where none of them suffices then."""
AT_A_TIME = 2
"""Of these, before it is seen whether one suffices: the same on every machine, on which the answer must not depend."""
EXCHANGES = 3
"""Times at most that a choice gives way to a rival with more evidence."""
AGAIN = 6
"""Rivals of a choice, those that leave least, that begin once more from its estimates unless they are far behind; not what contains
it, which has begun there if it left more."""
RIVALS = 3
"""Rivals of a choice, those that leave least, that are fitted on by exact derivatives before they are judged, unless they are far behind."""


@dataclass(frozen=True)
class Choice:
    """`best` hypothesis; `alternatives` that cannot be told apart from it, `same` of them on no logs of this kind of
    rig; `evidence` of everything that was tried, relative to the rig as it is; `ranking` single names with their share
    of the evidence."""

    best: Hypothesis
    alternatives: tuple[Hypothesis, ...]
    same: tuple[Hypothesis, ...]
    evidence: dict[Hypothesis, float]
    ranking: tuple[tuple[Hypothesis, float], ...]


class Search:
    """Compares hypotheses by their fits to the training logs."""

    def __init__(self, fits: ModelFits) -> None:
        self.fits = fits
        self.rig = fits.rig
        self.names = candidates(fits.rig)
        self.squares: dict[Hypothesis, tuple[Fit, dict[str, float]]] = {}
        self.count: dict[str, float] = {}

    def _seen(self, hypothesis: Hypothesis) -> dict[str, float]:
        fitted = self.fits.known(hypothesis)
        if hypothesis not in self.squares or self.squares[hypothesis][0] is not fitted:
            self.squares[hypothesis] = fitted, sums(residuals(fitted, self.fits.train))
            batch = fitted.problem.batch
            share = np.where(batch.weight > 0.0, batch.share, 0.0).sum(axis=(0, 1, 2))
            self.count = dict(zip(fitted.problem.structure.outputs, share, strict=True))
        return self.squares[hypothesis][1]

    def _numbers(self, hypothesis: Hypothesis) -> tuple[int, int]:
        """How many numbers of its own an hypothesis has, and how many of its effects' forms."""
        own = free_names(self.rig, hypothesis)[len(self.rig.free) :]
        form = sum(null_of_optional(name) is not None for name in own)
        return len(own) - form, form

    def evidence(self, hypothesis: Hypothesis, effective: dict[str, float]) -> float:
        """Log evidence of an hypothesis for given effective samples, and of what the rig file says besides."""
        fitted = self.fits.known(hypothesis)
        against, _ = fitted.problem.prior_cost(fitted.theta)
        return log_evidence(self._seen(hypothesis), *self._numbers(hypothesis), effective) - against

    def effective(self, hypothesis: Hypothesis) -> dict[str, float]:
        """Effective samples of an hypothesis's residual."""
        return effective_samples(residuals(self.fits.known(hypothesis), self.fits.train))

    def excess(self, hypothesis: Hypothesis) -> float:
        """Mean square of the residual above the noise, in units of the noise, summed over outputs."""
        squares = self._seen(hypothesis)
        return sum(max(squares[name] / self.count[name] - 1.0, 0.0) for name in squares)

    def closed(self, hypothesis: Hypothesis) -> float:
        """Share of the rig's own error above the noise, on the training logs, that an hypothesis removes, of the output where
        it removes most."""
        whole, left = self._seen(Hypothesis()), self._seen(hypothesis)
        error = [[np.sqrt(max(s[y] / self.count[y], 1.0)) for s in (whole, left)] for y in whole]
        shares = [(a - b) / (a - 1.0) if np.isfinite(a) else float(np.isfinite(b)) for a, b in error if a > 1.0]
        return max(shares, default=1.0)

    def gain(self, larger: Hypothesis, smaller: Hypothesis) -> float:
        """Evidence of the larger hypothesis over the smaller, counted on the better one's residual."""
        effective = self.effective(larger)
        return self.evidence(larger, effective) - self.evidence(smaller, effective)

    def worthwhile(self, larger: Hypothesis, smaller: Hypothesis) -> bool:
        """Whether the larger hypothesis is needed beside the smaller one."""
        removed = self.excess(smaller) - self.excess(larger)
        worth = WORTH_BESIDES if smaller.names else WORTH
        return bool(self.gain(larger, smaller) > NEEDED and removed > worth * self.excess(smaller))

    def _extensions(self, hypothesis: Hypothesis) -> list[Hypothesis]:
        found = []
        for name in self.names:
            if name not in hypothesis.names and name not in map(brought_by, hypothesis.names):
                found.append(hypothesis.without(brought_by(name)).plus(name))
        return found

    def _fit(self, hypotheses: list[Hypothesis], parent: Hypothesis) -> None:
        """Fits all from a parent; then the parent and special cases of what leads from there, and what leaves more than a
        special case of it from that one, unless that is far behind."""
        tried = self.fits.race(hypotheses, parent)
        least = min((f.cost for f in tried.values()), default=0.0)
        leading = sorted((e for e in tried if tried[e].cost <= CLOSE_COST * least), key=lambda e: tried[e].cost)
        for e in leading[:LEADING]:
            self.fits.race([o for o in (parent, *hypotheses) if e.contains(o)], e)
        best = min((parent, *tried), key=lambda e: self.fits.known(e).cost)
        for e in tried:
            special = [o for o in tried if e.contains(o) and self.fits.known(o).cost < self.fits.known(e).cost]
            special = [o for o in special if not self._far_behind(o, best)]
            if special:
                self.fits.race([e], min(special, key=lambda o: self.fits.known(o).cost))

    def _leader(self, hypotheses: list[Hypothesis]) -> Hypothesis:
        """The hypothesis with the most evidence, or a special case of it beside which it is not needed."""
        effective = self.effective(min(hypotheses, key=lambda e: self.fits.known(e).cost))
        best = max(hypotheses, key=lambda e: self.evidence(e, effective))
        simpler = [e for e in hypotheses if best.contains(e) and self.gain(best, e) <= NEEDED]
        return max(simpler, key=lambda e: self.evidence(e, effective), default=best)

    def _far_behind(self, hypothesis: Hypothesis, best: Hypothesis) -> bool:
        """Whether an hypothesis leaves so much more than one that reaches the noise that no further start is tried."""
        known = self.fits.known
        return bool(self.excess(best) <= NOTHING_LEFT and known(hypothesis).cost > BEHIND * known(best).cost)

    def _ahead(self, hypotheses: list[Hypothesis]) -> list[Hypothesis]:
        """Explanations, those that leave least first."""
        return sorted(hypotheses, key=lambda e: self.fits.known(e).cost)

    def _forward(self, hypothesis: Hypothesis) -> Hypothesis:
        enough = max(NOTHING_LEFT, TRIFLE * self.excess(hypothesis))
        while len(hypothesis.names) < MOST_NAMES and self.excess(hypothesis) > enough:
            if self.closed(hypothesis) < HOPEFUL[len(hypothesis.names)]:
                break
            tried = self._extensions(hypothesis)
            if not tried:
                break
            self._fit(tried, hypothesis)
            searched = self._ahead(tried)[: SEARCHED[len(hypothesis.names)]]
            for e in searched:
                if self.excess(self._leader(tried)) > enough:
                    self.fits.search(e, hypothesis)
            ahead = self._ahead(tried)[: EXACT[len(hypothesis.names)]]
            for k in range(0, len(ahead), AT_A_TIME):
                if self.excess(self._leader(tried)) > enough:
                    self.fits.exactly(ahead[k : k + AT_A_TIME])
            if not hypothesis.names:
                self._last_resort(tried, searched, enough)
            best = self._leader(tried)
            if not self.worthwhile(best, hypothesis):
                break
            hypothesis = best
        return hypothesis

    def _last_resort(self, hypotheses: list[Hypothesis], searched: list[Hypothesis], enough: float) -> None:
        """Single names that may begin at many places and were not searched so far, each searched while nothing suffices: between
        the places lie hills, over which no few steps show the way."""
        many = [e for e in self._ahead(hypotheses) if e not in searched and self.fits.places(e) >= MANY]
        for e in many:
            if self.excess(self._leader(hypotheses)) > enough:
                self.fits.search(e, Hypothesis())
        if many and self.excess(self._leader(hypotheses)) > enough:
            self.fits.exactly(self._ahead(hypotheses)[:AT_A_TIME])

    def _backward(self, hypothesis: Hypothesis) -> Hypothesis:
        while len(hypothesis.names) > 1:
            smaller = [hypothesis.without(name) for name in hypothesis.names]
            self._fit(smaller, hypothesis)
            effective = self.effective(hypothesis)
            best = max(smaller, key=lambda e: self.evidence(e, effective))
            if self.worthwhile(hypothesis, best):
                break
            hypothesis = best
        return hypothesis

    def _exchanged(self, hypothesis: Hypothesis) -> list[Hypothesis]:
        """Sets with one member exchanged; a member that includes another effect, also for that effect and another."""
        found = []
        for member in hypothesis.names:
            included = brought_by(member)
            rest = hypothesis.without(member)
            bare = [rest.plus(name) for name in self.names if name not in hypothesis.names]
            found += bare
            if included in self.names:  # which are what the rig file does not model
                found += [e.plus(included) for e in bare if included not in map(brought_by, e.names)]
        return [e for e in dict.fromkeys(found) if e != hypothesis]

    def _rivals(self, best: Hypothesis) -> list[Hypothesis]:
        """Sets with one member exchanged, fitted, those that leave least and are not far behind by exact derivatives like `best`
        itself; none where no name will stand."""
        if not best.names or (self.closed(best) < HOPELESS and self.excess(best) > NOTHING_NAMED):
            return []
        rivals = self._exchanged(best)
        self.fits.exactly([best])  # which may free the first states
        self._fit([e for e in rivals if e not in self.fits], best)
        near = [e for e in self._ahead(rivals) if not e.contains(best) and not self._far_behind(e, best)]
        self.fits.again(near[:AGAIN], best)
        self.fits.exactly([e for e in self._ahead(rivals)[:RIVALS] if not self._far_behind(e, best)])
        return rivals

    def _surpassing(self, best: Hypothesis, rivals: list[Hypothesis]) -> Hypothesis | None:
        """The rival with more evidence than `best`, of no more names."""
        effective = self.effective(best)
        able = [e for e in rivals if len(e.names) <= len(best.names)]
        first = max(able, key=lambda e: self.evidence(e, effective), default=best)
        return first if self.evidence(first, effective) > self.evidence(best, effective) + NEEDED else None

    def as_good(self, one: Hypothesis, other: Hypothesis) -> bool:
        """Whether `other` leaves hardly more than `one` where even `one` does not reach the noise."""
        a, b = self._seen(one), self._seen(other)
        incomplete = any(a[name] > FAR_FROM_NOISE * self.count[name] for name in a)
        return incomplete and all(b[name] < (1.0 + TIE) * a[name] for name in a)

    def nothing(self) -> Choice:
        """The rig as it is, without a search."""
        nothing = Hypothesis()
        return Choice(nothing, (), (), {nothing: 0.0}, ((nothing, 1.0),))

    def run(self) -> Choice:
        """The search from the rig as it is."""
        nothing = Hypothesis()
        self.fits(nothing)
        best = self._backward(self._forward(nothing))
        rivals = self._rivals(best)
        for _ in range(EXCHANGES):
            if (better := self._surpassing(best, rivals)) is None:
                break
            best = self._backward(better)
            rivals = self._rivals(best)
        effective = self.effective(best)
        reference = self.evidence(best, effective)
        close = [
            e
            for e in rivals
            if self.evidence(e, effective) > reference - (CLOSE_ABOVE if e.contains(best) else CLOSE)
            or (self.as_good(best, e) and not e.contains(best))
        ]
        alternatives = [e for e in close if not any(e.contains(other) for other in close)]
        alternatives.sort(key=lambda e: -self.evidence(e, effective))
        same = equivalents(self.fits, self.names, best)
        alternatives += [e for e in same if e not in alternatives]
        everything = [e for e in self.squares]
        base = self.evidence(nothing, effective)
        evidence = {e: self.evidence(e, effective) - base for e in everything}
        return Choice(best, tuple(alternatives), tuple(same), evidence, self._ranking(nothing, best, effective))

    def _ranking(
        self, nothing: Hypothesis, best: Hypothesis, effective: dict[str, float]
    ) -> tuple[tuple[Hypothesis, float], ...]:
        """Shares of the evidence among the rig as it is, the single names and the best set."""
        field = list(dict.fromkeys([*self._extensions(nothing), best, nothing]))
        field = [e for e in field if e in self.fits or not e.names]
        values = np.array([self.evidence(e, effective) for e in field])
        share = np.exp(values - values.max())
        share /= share.sum()
        order = np.argsort(-values, kind="stable")
        return tuple((field[k], float(share[k])) for k in order)
