"""What may be claimed of a choice: names that hold, beside which nothing else holds a part, and for which no law outside the list can stand."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.corrected_rig import corrected_rig
from rwjax.diagnosis.exact_fits import polish
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.judged import Judged
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.outside_laws import doing_as_well, outside_laws_of
from rwjax.diagnosis.partial import BEATEN, Claim, claimed
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.diagnosis.uninformative import diverged_numbers, stands_still
from rwjax.diagnosis.verdict import CLAIMS, Verdict, judge, leaves_a_visible_part, left_elsewhere
from rwjax.diagnosis.words import beside_runaways
from rwjax.fitting.ran_away import ran_away
from rwjax.fitting.uncertainty import uncertainty
from rwjax.logs.segments import runs_of


@dataclass(frozen=True)
class Further:
    """A choice, and what of it may be claimed.

    Attributes:
        judged: held-out errors of hypotheses.
        choice: the choice, after the search has gone on where it leaves a visible part.
        claim: what holds though it leaves something, None where nothing does or the choice is the whole answer.
        refused: names that may not be claimed, and why.
        outside: a set that may not be claimed, and the same with a law outside the list in it, which does as well; else none.
        held: numbers of the rig that ran away beside names that may not be claimed for it.
        ended: whether the budget ended this stage, beside whose end a claim is of what was compared until then.
        followed: whether only the held-out runs show a visible part.
    """

    judged: Judged
    choice: Choice
    claim: Claim | None = None
    refused: dict[str, str] = field(default_factory=dict)
    outside: tuple[Hypothesis, ...] = ()
    held: tuple[str, ...] = ()
    ended: bool = False
    followed: bool = False

    @property
    def complete(self) -> bool:
        """Whether the whole search came to its end."""
        return self.choice.complete and not self.ended

    @property
    def answers(self) -> bool:
        """Whether something may be said of what was found: the search came to its end, or a part holds of what it had come to."""
        return self.complete or self.claim is not None


def may_be_claimed(judged: Judged, choice: Choice, names: Sequence[str]) -> Further:
    """What may be claimed of a choice; where it leaves a visible part, the search goes on first.

    Args:
        judged: held-out errors of hypotheses.
        choice: what a search has chosen.
        names: names that might be missing.

    Returns:
        The choice with what may be claimed of it.
    """
    return _told_apart(_moving(_with_equals(_gone_on(judged, choice, names))))


def _may_ask(judged: Judged, choice: Choice) -> bool:
    """Whether enough training runs were searched to tell what holds."""
    fits = judged.fits
    runs = len(np.unique(runs_of(fits.problem.logs)[list(fits.train)]))
    searched = choice.complete and (bool(choice.best.names) or len(choice.criterion) > 1)
    return searched and runs >= fits.settings.partial.runs


def _gone_on(judged: Judged, choice: Choice, names: Sequence[str]) -> Further:
    """What holds of a choice that is not the whole answer, by the training runs.

    Where these show that something is left, the search goes on first: a visible part of them, or anything where the held-out runs show that
    it counts. Where the training runs leave nothing, it does not.
    """
    fits = judged.fits
    if not _may_ask(judged, choice):
        return Further(judged, choice)
    compare = ModelComparison(fits)
    visible = compare.leaves_visible(choice.best)
    if not visible and _verdict_of(judged, choice) != "unknown":
        return Further(judged, choice)
    search, budget = FurtherSearch(fits, names), fits.headway.budget
    more = compare.leaves_something(choice.best)
    try:
        with budget.searching():
            if more:
                fits.free_starts_of_what_leads()
            further = search.go_on(choice.best) if more else choice
    except Stopped:
        further = None
    try:
        with budget.searching():
            if further is None:
                return _so_far(judged, search, choice, followed=not visible)
            held = _holding(judged, search, further, followed=not visible)
            if held.claim is None and choice.best.names and choice.best != further.best:
                first = search.chosen(choice.best, search.rivals(choice.best))
                held = _first_of_two(_holding(judged, search, first, followed=not visible), held)
            return held if held.claim else replace(held, choice=choice)
    except Stopped:
        return Further(judged.anew(), choice, ended=True)


def _so_far(judged: Judged, search: FurtherSearch, choice: Choice, *, followed: bool) -> Further:
    """What holds where the budget has ended the search that went on from a choice: of what no rival had surpassed by then."""
    if search.settled is not None:
        held = _holding(judged, search, search.settled, followed=followed)
        if held.claim:
            return replace(held, ended=True)
    return Further(judged.anew(), choice, ended=True)


def _holding(judged: Judged, search: FurtherSearch, choice: Choice, *, followed: bool) -> Further:
    """What holds of a choice, beside which no other explanation leaves much less of the held-out runs."""
    if choice.best.names:
        polish(search.fits, choice.best)
    claim, refused = claimed(search, choice)
    if claim is not None and claim.named != choice.best:
        choice = search.chosen(claim.named, [e for e in claim.rivals if len(e.names) <= len(claim.named.names)])
    judged = judged.anew()
    if claim is not None and _beaten(judged, choice, claim):
        claim, refused = None, refused | dict.fromkeys(claim.named.names, BEATEN)
    return Further(judged, choice, claim, refused, followed=followed and claim is not None)


def _first_of_two(first: Further, beside: Further) -> Further:
    """What holds of a first choice where nothing holds beside further names, which are then refused; else the answer with these."""
    if first.claim is None:
        return replace(beside, refused=first.refused | beside.refused)
    named = first.claim.named.names
    return replace(first, refused={n: why for n, why in beside.refused.items() if n not in named} | first.refused)


def _claims(further: Further) -> Hypothesis | None:
    """The names that are to be claimed, None where nothing is."""
    if further.claim:
        return further.claim.named
    if not further.complete:
        return None
    claims = not further.refused and _verdict_of(further.judged, further.choice) in CLAIMS
    return further.choice.best if claims else None


def _with_equals(further: Further) -> Further:
    """The same, a whole answer with the sets beside it that leave as little of every output's held-out runs by no more numbers.

    Evidence that tells these apart is of less than what any rig file leaves out. A law of more numbers may follow anything as well: there
    the evidence decides, and so it does between a law and its special case.
    """
    judged, choice = further.judged, further.choice
    if further.claim or _claims(further) is None:
        return further
    fits, best, known = judged.fits, choice.best, (choice.best, *choice.alternatives)
    first = [e for e, _ in choice.ranking[: fits.settings.report.ranked] if e.names]
    others = [e for e in first if not any(_nested(e, one) for one in known)]
    judged.prepare(others)
    most, numbers = 1.0 + fits.settings.search.equal, len(fits(best).free)
    least = {name: gap.after for name, gap in judged.gaps(judged(best)).items()}
    equal = [
        e
        for e in others
        if len(fits(e).free) <= numbers and all(judged(e).rms(name) <= most * after for name, after in least.items())
    ]
    return replace(further, choice=replace(choice, alternatives=(*choice.alternatives, *equal)))


def _nested(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two sets are the same or one is a special case of the other: then what the larger adds is needed, or it is not."""
    return one == other or one.contains(other) or other.contains(one)


def _moving(further: Further) -> Further:
    """The same, without a claim beside which an output stands still by a number of the rig that ran away.

    What holds a part at rest looks like a number without end. So something holds it that is not named.
    """
    named = _claims(further)
    if named is None:
        return further
    fits = further.judged.fits
    left = diverged_numbers(fits.rig, fits(named), fits.settings.remarks)
    if not left or not stands_still(fits(named), fits.settings.remarks):
        return further
    fitted = corrected_rig(fits.rig, named, fits(named), uncertainty(fits(named)))
    away = tuple(name for name in left if name in ran_away(fits.rig, fitted))
    if not away:
        return further
    why = beside_runaways({name: fitted.values[name] / fits.rig.values[name] for name in away})
    refused = further.refused | dict.fromkeys(named.names, why)
    return replace(further, claim=None, refused=refused, held=away)


def _told_apart(further: Further) -> Further:
    """The same, without a claim of which a law outside the list of effects does as well in the place of one of the names.

    Where the claimed names are a special case of the law, they stand unless what the law adds is needed.
    """
    judged, named = further.judged, _claims(further)
    if named is None:
        return further
    asked = outside_laws_of([named, *(further.claim or further.choice).alternatives])
    if not asked:
        return further
    try:
        with judged.fits.headway.budget.searching():
            found = doing_as_well(judged.fits, asked)
    except Stopped:
        return replace(further, judged=judged.anew(), claim=None, ended=True)
    gain, needed = ModelComparison(judged.fits).gain, judged.fits.settings.search.needed
    found = [one for one in found if not one.instead.contains(named) or gain(one.instead, named) > needed]
    further = replace(further, judged=judged.anew())
    if not found:
        return further
    refused = {one.name: one.why for one in found}
    refused |= {name: why for name, why in further.refused.items() if name not in refused}
    return replace(further, claim=None, refused=refused, outside=(found[0].of, found[0].instead))


def _verdict_of(judged: Judged, choice: Choice) -> Verdict:
    """The outcome of a choice by the held-out runs."""
    return judge(choice, judged.gaps(judged(choice.best)), judged.signal, judged.fits.settings.verdict)


def _beaten(judged: Judged, choice: Choice, claim: Claim) -> bool:
    """Whether another explanation than those of a claim, or the rig as it is, leaves so much less that the claim stands in for something else.

    What counts are held-out runs, and the output that keeps a visible part.
    """
    settings, gaps = judged.fits.settings, judged.gaps(judged(claim.named))
    signal = left_elsewhere(gaps, judged.signal, settings.verdict) or judged.signal
    gap = gaps[signal]
    if not leaves_a_visible_part(gap, settings.verdict):
        return False
    own = (claim.named, *claim.alternatives)
    first = [NOTHING, *(e for e, _ in choice.ranking[: settings.report.ranked])]
    others = [e for e in first if not any(e == one or e.contains(one) for one in own)]
    judged.prepare(others)
    most = (1.0 - settings.search.further_removes) * (gap.after**2 - gap.floor**2)
    return any(judged(e).rms(signal) ** 2 - gap.floor**2 < most for e in others)
