"""Forward-backward search: the smallest set of effects that explains the training logs, and every other set that does as well.

Forward: the candidate with the best information criterion is added while the logs need it. Backward: a name that they do not need is
dropped again. Then every member is exchanged for every other candidate. A set whose criterion comes close to the best one's cannot be
told apart from it on these logs. The same holds for a set that ties with it where nothing reaches the noise, and for what is declared
to be the same thing for the kind of rig.
"""

from collections.abc import Mapping, Sequence

from rwjax.diagnosis.exact_fits import fit_exactly
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis, simplest, spoken
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.equivalents import equivalents
from rwjax.diagnosis.search.neighbours import exchanges, extensions
from rwjax.diagnosis.search.pairs import promising_pairs
from rwjax.diagnosis.search.strategy import Strategy
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from rwjax.fitting.multiple_shooting import Fit


class ForwardBackward(Strategy):
    """The usual search: forward selection, backward elimination, exchanges; its fits by successive halving."""

    def choose(self, fits: ModelFits, candidates: Sequence[str]) -> Choice:
        """Chooses a hypothesis by fits to the training logs.

        Args:
            fits: the rig's fits, that of the rig as it is among them; the search adds its own.
            candidates: names that might be missing.

        Returns:
            The choice, with what was tried.
        """
        return Search(fits, candidates).run()


class Search:
    """The steps of the search.

    Args:
        fits: where the fits are kept.
        candidates: names that might be missing.
        comparison: how hypotheses are compared, by the evidence where none is given.

    Attributes:
        fits: where the fits are kept.
        candidates: names that might be missing.
        halving: how many hypotheses are fitted at a time.
        comparison: how hypotheses are compared.
        limits: limits of the search.
    """

    def __init__(self, fits: ModelFits, candidates: Sequence[str], comparison: ModelComparison | None = None) -> None:
        self.fits = fits
        self.candidates = tuple(candidates)
        self.halving = SuccessiveHalving(fits)
        self.comparison = comparison or ModelComparison(fits)
        self.limits = fits.settings.search
        self._pairs: list[Hypothesis] | None = None

    def run(self) -> Choice:
        """Searches from the rig as it is.

        Returns:
            The choice, with what was tried.
        """
        self.fits(NOTHING)
        return self.chosen(*self.exchanged(self.forward(NOTHING, self.limits.most_names)))

    def exchanged(self, best: Hypothesis) -> tuple[Hypothesis, list[Hypothesis]]:
        """A hypothesis without the names that are not needed, or what surpasses it.

        Args:
            best: the hypothesis, with a fit that has begun.

        Returns:
            What no rival surpasses, and its rivals.
        """
        return self.given_way(self.backward(best))

    def given_way(self, best: Hypothesis) -> tuple[Hypothesis, list[Hypothesis]]:
        """A hypothesis, or what surpasses it.

        Args:
            best: the hypothesis, all of whose names are needed.

        Returns:
            What no rival surpasses, and its rivals.
        """
        rivals = self.rivals(best)
        for _ in range(self.limits.exchanges):
            if (better := self.surpassing(best, rivals)) is None:
                break
            smaller = self.backward(better)
            # where even the choice is needed in place of the smaller set, so is what surpasses the choice
            best = better if self.comparison.needs(best, smaller) else smaller
            rivals = self.rivals(best)
        return best, rivals

    def pairs(self) -> list[Hypothesis]:
        """Two names at a time, those that are predicted to leave least, with fits that have begun.

        Returns:
            The pairs, the same at every call.
        """
        if self._pairs is None:
            self._pairs = self.fit_pairs(promising_pairs(self.fits, self.candidates))
        return self._pairs

    def fit_pairs(self, places: Mapping[Hypothesis, Sequence[Fit]]) -> list[Hypothesis]:
        """Fits pairs from where they are predicted to leave least.

        Args:
            places: points without a step, by pair.

        Returns:
            The pairs with fits that have begun.
        """
        exact = self.limits.exactly_at_once * self.fits.settings.headway.exact
        self.fits.headway.enter([*places], "pairs", besides=exact, further=0.0)
        return self.halving.fit_at(places, self.fits.settings.pairs)

    def chosen(self, best: Hypothesis, rivals: Sequence[Hypothesis]) -> Choice:
        """The choice of a hypothesis, with those of its rivals that cannot be told apart from it.

        Args:
            best: the hypothesis.
            rivals: its rivals, with fits that have begun.

        Returns:
            The choice.
        """
        compare, limits = self.comparison, self.limits
        effective = compare.effective(best)
        reference = compare.criterion(best, effective)

        def is_close(e: Hypothesis) -> bool:
            within = limits.close_containing if e.contains(best) else limits.close
            near = compare.criterion(e, effective) > reference - within
            near = near or (compare.ties(best, e) and not e.contains(best))
            return near and not compare.leaves_more(e, best)

        close = [e for e in rivals if is_close(e)]
        alternatives = simplest(close)
        alternatives.sort(key=lambda e: -compare.criterion(e, effective))
        same = equivalents(self.fits, self.candidates, best)
        alternatives += [e for e in same if e not in alternatives]
        tried = compare.compared
        base = compare.criterion(NOTHING, effective)
        criterion = {e: compare.criterion(e, effective) - base for e in tried}
        ranked = list(dict.fromkeys([*extensions(self.candidates, NOTHING), best, NOTHING]))
        ranked = [e for e in ranked if e in self.fits or not e.names]
        return Choice(best, tuple(alternatives), tuple(same), criterion, compare.probabilities(ranked, effective))

    def forward(self, hypothesis: Hypothesis, most: int) -> Hypothesis:
        """Adds names while the logs need them.

        Args:
            hypothesis: where to begin, with a fit at its end.
            most: names at most.

        Returns:
            The hypothesis with the names added.
        """
        excess, limits = self.comparison.excess, self.limits
        enough = max(limits.nothing_left, limits.negligible * excess(hypothesis))
        while len(hypothesis.names) < most and excess(hypothesis) > enough:
            if self.comparison.removed(hypothesis) < limits.removed_so_far[len(hypothesis.names)]:
                break
            tried = extensions(self.candidates, hypothesis)
            if not tried:
                break
            self.announce(tried, hypothesis)
            if not self.fits.fitted_from(hypothesis, tried):
                self.fits.take_down(hypothesis, tried)
                self._fit(tried, hypothesis)
            self._fit_thoroughly(tried, hypothesis, enough)
            best = self.comparison.leader(tried)
            if not self.comparison.needs(best, hypothesis):
                break
            hypothesis = best
        return hypothesis

    def announce(self, tried: Sequence[Hypothesis], hypothesis: Hypothesis, passes: int = 0) -> None:
        """Says that one name more is tried, and how much work this is and what follows it.

        Args:
            tried: hypotheses with one name more.
            hypothesis: what they extend.
            passes: how many passes of the same kind follow for sure.
        """
        work = self.fits.settings.headway
        self.fits.headway.enter(
            tried,
            " beside ".join(["candidates", *map(spoken, hypothesis.names)]),
            besides=work.exact,
            further=(1 + passes) * len(self.candidates) + self.limits.rivals_exactly * work.exact,
        )

    def backward(self, hypothesis: Hypothesis) -> Hypothesis:
        """Drops names while the logs do not need them.

        Args:
            hypothesis: where to begin, with a fit that has begun.

        Returns:
            The hypothesis without the names dropped, one name at the least.
        """
        compare = self.comparison
        while len(hypothesis.names) > 1:
            smaller = [hypothesis.without(name) for name in hypothesis.names]
            self._fit(smaller, hypothesis)
            effective = compare.effective(hypothesis)
            enough = [e for e in smaller if not compare.needs(hypothesis, e)]
            if not enough:
                break
            hypothesis = compare.first_of(enough, effective)
        return hypothesis

    def rivals(self, best: Hypothesis) -> list[Hypothesis]:
        """Fits the hypotheses with one member exchanged, beside two names also the other promising pairs.

        Leading ones are fitted once more from the estimates of `best`: a fit that was left behind on its way may have been as good. Those
        that leave least and are not far behind are fitted by exact derivatives, like `best` itself.

        Args:
            best: the choice so far.

        Returns:
            The rivals; none where the choice removes so little that no name will stand.
        """
        compare, limits = self.comparison, self.limits
        if not best.names:
            return []
        if compare.removed(best) < limits.rivals_removed and compare.excess(best) > limits.rivals_excess:
            return []
        rivals = exchanges(self.candidates, best)
        if len(best.names) == 2:
            rivals += [e for e in self.pairs() if e != best and e not in rivals]
        exact = limits.rivals_exactly * self.fits.settings.headway.exact
        self.fits.headway.enter(rivals, "rivals", besides=limits.again + exact, further=0.0)
        fit_exactly(self.fits, [best])  # which may free the first states
        self._fit([e for e in rivals if not self.fits.stepped(e)], best)
        begun = [e for e in self._by_cost(rivals) if not e.contains(best)]  # those that contain it have begun there
        near = [e for e in begun if not self._far_behind(e, best) or compare.removed(e) >= limits.again_removed]
        self.halving.fit_again(near[: limits.again], best)
        leading = self._by_cost(rivals)[: limits.rivals_exactly]
        fit_exactly(self.fits, [e for e in leading if not self._far_behind(e, best)])
        return rivals

    def surpassing(self, best: Hypothesis, rivals: list[Hypothesis]) -> Hypothesis | None:
        """The rival of no more names that has a better information criterion by enough, or leaves clearly less; one that contains the choice, where it is needed.

        Args:
            best: the choice so far.
            rivals: its rivals, with fits that have begun.

        Returns:
            The rival, or None where there is none.
        """
        compare = self.comparison
        effective = compare.effective(best)
        able = [e for e in rivals if len(e.names) <= len(best.names)]
        able = [e for e in able if not e.contains(best) or compare.needs(e, best)]
        if not able or compare.leaves_more(first := compare.first_of(able, effective), best):
            return None
        if compare.leaves_more(best, first) and compare.needs(first, NOTHING):
            return first
        surpasses = compare.criterion(first, effective) > compare.criterion(best, effective) + self.limits.needed
        return first if surpasses else None

    def _fit(self, hypotheses: list[Hypothesis], parent: Hypothesis) -> None:
        """Fits hypotheses from a parent, then from one another.

        The parent and the special cases of a leading hypothesis begin again from that one. A hypothesis that leaves more than a
        special case of it begins again from that one, unless that one is far behind.
        """
        known, limits = self.fits.known, self.limits
        tried = self.halving.fit(hypotheses, parent)
        least = min((f.cost for f in tried.values()), default=0.0)
        leading = sorted(
            (e for e in tried if tried[e].cost <= limits.leading_cost * least), key=lambda e: tried[e].cost
        )
        for e in leading[: limits.leading]:
            self.halving.fit([o for o in (parent, *hypotheses) if e.contains(o)], e)
        best = min((parent, *tried), key=lambda e: known(e).cost)
        rest = [*tried]
        while rest:  # those first whose special cases do not begin again themselves
            now = [e for e in rest if not any(e.contains(o) for o in rest if o != e)] or rest
            rest = [e for e in rest if e not in now]
            parents = {e: min((o for o in tried if e.contains(o)), key=lambda o: known(o).cost, default=e) for e in now}
            less = {e: o for e, o in parents.items() if known(o).cost < known(e).cost and not self._far_behind(o, best)}
            if less:
                self.halving.fit_each(less)

    def _fit_thoroughly(self, tried: list[Hypothesis], parent: Hypothesis, enough: float) -> None:
        """Carries the leading hypotheses on, from all of their places and by exact derivatives, until one suffices.

        From all places the leading ones are fitted until one comes near the noise, however little of the rig's own excess they leave: which
        of them leads above it is a matter of small differences, and one may have come to a place that is not its best.
        """
        limits, beside = self.limits, len(parent.names)
        searched = self._by_cost(tried)[: limits.from_all_places[beside]]
        self._fit_from_all_places(searched, parent, tried, min(enough, self.fits.settings.verdict.doubt**2))
        ahead = self._by_cost(tried)[: limits.exactly[beside]]
        for k in range(0, len(ahead), limits.exactly_at_once):
            if not self._suffices(tried, enough):
                fit_exactly(self.fits, ahead[k : k + limits.exactly_at_once])
        if not parent.names:
            self.fit_from_many_places([e for e in tried if e not in searched], tried, enough)

    def fit_from_many_places(self, hypotheses: list[Hypothesis], tried: list[Hypothesis], enough: float) -> None:
        """Fits the hypotheses that may begin at many places from all of these, while nothing suffices.

        Between the places lie hills of the cost, over which a few steps do not show the way.

        Args:
            hypotheses: those to fit, of which only some may begin at many places.
            tried: hypotheses among which one may suffice.
            enough: excess up to which a hypothesis suffices [1].
        """
        many = [e for e in self._by_cost(hypotheses) if len(self.fits.space(e)[1]) >= self.limits.many_places]
        self._fit_from_all_places(many, NOTHING, tried, enough)
        if many and not self._suffices(tried, enough):
            fit_exactly(self.fits, self._by_cost(tried)[: self.limits.exactly_at_once])

    def _fit_from_all_places(
        self, hypotheses: list[Hypothesis], parent: Hypothesis, tried: list[Hypothesis], enough: float
    ) -> None:
        """Fits hypotheses from all of their places, a few side by side, until one suffices.

        What comes after that one does not count, so that the answer is that of one after the other. Where the budget ends, those that are
        on their way are lost.
        """
        at_once = self.limits.from_all_places_at_once
        for k in range(0, len(hypotheses), at_once):
            if self._suffices(tried, enough):
                break
            self.fits.headway.doing("those ahead from all of their places")
            for e, fitted in self.halving.from_all_places(hypotheses[k : k + at_once], parent).items():
                if not self._suffices(tried, enough):
                    self.fits.keep({e: fitted})
        self.fits.headway.doing("")

    def _suffices(self, hypotheses: list[Hypothesis], enough: float) -> bool:
        """Whether the leading hypothesis leaves at most so much excess."""
        return not self.comparison.excess(self.comparison.in_sample.leader(hypotheses)) > enough

    def _far_behind(self, hypothesis: Hypothesis, best: Hypothesis) -> bool:
        """Whether a hypothesis leaves so much more than one that reaches the noise that no further start is tried."""
        known, behind = self.fits.known, self.fits.settings.halving.behind
        complete = self.comparison.excess(best) <= self.limits.nothing_left
        return bool(complete and known(hypothesis).cost > behind * known(best).cost)

    def _by_cost(self, hypotheses: list[Hypothesis]) -> list[Hypothesis]:
        """Hypotheses, those with the least cost first."""
        return sorted(hypotheses, key=lambda e: self.fits.known(e).cost)
