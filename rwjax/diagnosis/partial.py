"""What holds of an explanation that leaves a visible part: which of its names may be claimed under `partial`.

Everything is decided on training runs. A name holds where

* it is needed beside a remainder that is coloured noise, by the likelihood of each reading beside the ones before
  (`rwjax.diagnosis.coloured_comparison`); every run, and commands of every size, ask for as much of it
  (`rwjax.diagnosis.agreement`), and left-out runs are
  followed no worse with it than without, but for those that hold little of its change and ask for as much of it. Or else it explains nearly all of the runs, also of those that were left out in turn, or most
  of these, and all parts together ask for it evenly;
* a free-form law of its coordinate explains no more of the missing torque with it than without (`rwjax.diagnosis.localise.law`), and no
  further law of the coordinate with which left-out runs are followed better removes part of what it leaves and changes it;
* its rivals leave clearly more in proportion to what it leaves, of the fitted runs or of left-out ones, or are far less likely beside a remainder that is an autoregression. Others
  that leave about as much stand beside it as alternatives, where what they have of their own is needed and all runs ask for as much of it.
  A name that many of them do without is not claimed. Of several names only those are claimed that all of these explanations share, where
  they close enough by themselves.

Each name is judged beside all others of its set, also beside those that do not hold: these stand for what else is missing.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.agreement import Amplitude, amplitudes, unevenness
from rwjax.diagnosis.comparison_by_runs import ComparisonByRuns
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis, coordinate_of, simplest
from rwjax.diagnosis.innovations import log_likelihood
from rwjax.diagnosis.localise.law import law_left
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.equivalents import equivalents
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.diagnosis.search.neighbours import exchanges, extensions
from rwjax.diagnosis.search.successive_halving import fitted
from rwjax.diagnosis.settings import PartialSettings
from rwjax.effects.library import BY_NAME, included_in, is_outside, models
from rwjax.effects.parameter import parameters

MANY = "many other names leave about as much"
BEATEN = "another explanation leaves clearly less of the held-out runs"
EXCHANGED = "other names in its place, beside the rest, leave about as much"


class Claim(NamedTuple):
    """Names that hold, though they leave something.

    Attributes:
        named: the named set.
        alternatives: the sets of which one may stand in its place.
        equivalents: those of the alternatives that no logs of this kind of rig can tell apart from it.
        rivals: the sets that were compared with it; none where the search itself has chosen it.
    """

    named: Hypothesis
    alternatives: tuple[Hypothesis, ...]
    equivalents: tuple[Hypothesis, ...]
    rivals: tuple[Hypothesis, ...] = ()


class Holding(NamedTuple):
    """What holds of an explanation.

    Attributes:
        claim: the part that holds, None where nothing does.
        refused: each name that does not hold, and why not, in words.
    """

    claim: Claim | None
    refused: dict[str, str]


def claimed(search: FurtherSearch, choice: Choice) -> Holding:
    """The part of an explanation that holds.

    Each name is judged beside the others. Those that do not hold are not claimed, but they stay beside the rest while this is judged: they
    stand for what else is missing. Where none holds, the one that brings least is dropped, and the rest is judged anew: two names may
    stand in for each other.

    Args:
        search: the search that has found it.
        choice: the explanation, with a fit at its end; where it comes near the noise, the evidence says what stands beside it.

    Returns:
        What holds, and why the rest does not.
    """
    best, refused = choice.best, dict[str, str]()
    while best.names:
        here = _judged(search, best)
        if len(here) < len(best.names):
            return _claim(search, choice, best, refused | here)
        least = min(here, key=lambda name: search.by_runs.gain(best, _without(search.fits, best, name)))
        refused[least] = here[least]
        best = best.without(least)
    return Holding(None, refused)


def _judged(search: FurtherSearch, best: Hypothesis) -> dict[str, str]:
    """The names of a set that do not hold beside the others, and why; where it comes near the noise, no further name is fitted."""
    fits = search.fits
    fitted(fits, best)
    refused = _failing({name: why_not_in_every_run(search.by_runs, best, name) for name in best.names})
    rest = [name for name in best.names if name not in refused]
    if not _near_the_noise(search, best):
        akin = [name for name in search.candidates if any(_akin(name, one) for one in rest)]
        search.halving.fit([e for e in extensions(akin, best) if not fits.stepped(e)], best)
    return refused | _failing({name: why_not_of_its_form(search.by_runs, best, name) for name in rest})


def _near_the_noise(search: FurtherSearch, best: Hypothesis) -> bool:
    """Whether a set leaves no more of the training runs than a right one may."""
    return bool(np.sqrt(search.comparison.excess(best)) < search.fits.settings.verdict.doubt)


def _claim(search: FurtherSearch, choice: Choice, best: Hypothesis, refused: dict[str, str]) -> Holding:
    """What is claimed of a set, some names of which hold, beside its rivals."""
    if best == choice.best and not refused and _near_the_noise(search, best):
        return Holding(Claim(best, choice.alternatives, choice.equivalents), refused)
    rivals = _rivals(search, best)
    if rivals is None:
        return Holding(None, dict.fromkeys(best.names, "together they remove too little") | refused)
    about_as_much, most = _near(search, best, rivals), search.fits.settings.partial.alternatives
    while (named := _apart(best, refused)).names:
        near = _as_likely(search.fits, named, about_as_much)
        many = {name: MANY for name in named.names if sum(name not in e.names for e in near) > most}
        if not many:
            shared = _shared(search, named, near)
            refused = refused | {name: EXCHANGED for name in named.names if name not in shared.names}
            given_up = {*best.names} & {*refused}
            beside = simplest([_apart(e, given_up) for e in near if not {*shared.names} <= {*e.names}])
            return Holding(_beside(search, shared, beside, rivals), refused)
        refused = refused | many
    return Holding(None, refused)


def _shared(search: FurtherSearch, named: Hypothesis, near: Sequence[Hypothesis]) -> Hypothesis:
    """Those of some names that every explanation holds which leaves about as much; all of them where these remove too little."""
    shared = _apart(named, [name for name in named.names if any(name not in e.names for e in near)])
    if not shared.names or shared == named:
        return named
    fitted(search.fits, shared)
    excess, closes = search.comparison.excess, search.fits.settings.partial.closes
    enough = np.isfinite(excess(shared)) and excess(shared) <= (1.0 - closes) ** 2 * excess(NOTHING)
    return shared if enough else named


def _failing(reasons: Mapping[str, str | None]) -> dict[str, str]:
    """The names that fail a test, and why."""
    return {name: why for name, why in reasons.items() if why is not None}


def why_not_in_every_run(by_runs: ComparisonByRuns, best: Hypothesis, name: str) -> str | None:
    """Why a name is not needed, or not in the same amount by every run; one that explains nearly all of these, or most of them evenly, is not asked.

    Args:
        by_runs: compares sets by left-out runs, too; a fit of the set is at its end.
        best: the set.
        name: one of its names.

    Returns:
        The first test that it fails, in words; None where it holds.
    """
    fits, left_out = by_runs.fits, by_runs.left_out
    limits, smaller = fits.settings.partial, _without(fits, best, name)
    fitted(fits, smaller)
    if _explains_nearly_all(by_runs, best, smaller):
        return None
    parts = amplitudes(fits, best, smaller)
    if _explains_most_alike(by_runs, best, smaller, parts):
        return None
    if not by_runs.in_sample.likelier(best, smaller):
        return "it is not needed beside a remainder that is coloured noise"
    if any(a.weight >= limits.weighs and _differs(a, limits) for a in parts):
        return "runs or sizes of the command ask for different amounts of it"
    telling = _telling(parts, limits)
    if len(telling) < limits.runs:
        return "too few runs tell how much of it they ask for"
    with_it, without = left_out(best), left_out(smaller)
    worse = [a for a in telling if with_it[a.run or 0] > limits.harms * without[a.run or 0]]
    if worse and not _say_little(worse, [a for a in telling if a not in worse], limits):
        return "a run that is left out is followed worse with it"
    return None


def _explains_most_alike(
    by_runs: ComparisonByRuns, best: Hypothesis, smaller: Hypothesis, parts: Sequence[Amplitude]
) -> bool:
    """Whether a name explains most of the left-out runs, and all parts together ask for it evenly.

    Small parts may then ask for another amount, or be followed worse: what else is missing does that to a run that moves little. And a small
    gain by the reading is enough, since coloured noise does not come again in another run.
    """
    limits, left_out = by_runs.fits.settings.partial, by_runs.left_out
    of_fitted, of_left_out = _shares(by_runs, best, smaller)
    if not (of_fitted < limits.mostly_fitted and of_left_out < limits.mostly):
        return False
    with_it, without = left_out(best), left_out(smaller)
    worse = [a for a in parts if a.run is not None and with_it[a.run] > limits.harms * without[a.run]]
    even = len(_telling(parts, limits)) >= limits.runs and unevenness(parts) <= limits.uneven
    return even and sum(a.weight for a in worse) < limits.harmed and by_runs.in_sample.gains_altogether(best, smaller)


def _telling(parts: Sequence[Amplitude], limits: PartialSettings) -> list[Amplitude]:
    """The runs that tell the amplitude, and ask for as much as all."""
    return [a for a in parts if a.run is not None and a.error <= limits.differs and not _differs(a, limits)]


def _say_little(worse: Collection[Amplitude], others: Collection[Amplitude], limits: PartialSettings) -> bool:
    """Whether runs that are followed worse with a name hold little of what that changes, and ask for as much of it as others that are not."""
    ask_for_as_much = [abs(a.value - 1.0) <= limits.closely for a in worse]
    alike = [a for a in others if a.weight >= limits.weighs and abs(a.value - 1.0) <= limits.closely]
    return sum(a.weight for a in worse) < limits.harmed and all(ask_for_as_much) and len(alike) >= limits.runs


def why_not_of_its_form(by_runs: ComparisonByRuns, best: Hypothesis, name: str) -> str | None:
    """Why what is missing has another form than a name.

    A name that leaves little of what is left without it, of the fitted runs or of the left-out ones, has about the right form. What it leaves may be a small cause of its coordinate,
    so that only a further law that removes most of it speaks against the name. One with which the left-out runs are followed no better says nothing.

    Args:
        by_runs: compares sets by left-out runs, too; a fit of the set is at its end, and there are fits of what extends it.
        best: the set.
        name: one of its names.

    Returns:
        The first test that it fails, in words; None where it holds.
    """
    fits = by_runs.fits
    limits, smaller = fits.settings.partial, _without(fits, best, name)
    fitted(fits, smaller)
    little = any(share <= limits.little for share in _shares(by_runs, best, smaller))
    little = little or _explains_nearly_all(by_runs, best, smaller)
    left = None if little else law_left(fits, best, smaller, name)
    beside = any(coordinate_of(other) == coordinate_of(name) for other in best.names if other != name)
    if left is not None and left > (limits.law_left_beside if beside else limits.law_left):
        return "a free-form law of its coordinate explains more"
    most = limits.further_law_of_little if little else limits.further_law
    for other, (share, e) in _further(fits, best).items():
        explains = share > most and _akin(other, name) and by_runs.follows_better(e, best)
        if explains and not _stays(by_runs, best, e, name):
            return "a further law of its coordinate removes part of what it leaves, and changes it"
    return None


def _stays(by_runs: ComparisonByRuns, best: Hypothesis, larger: Hypothesis, name: str) -> bool:
    """Whether a name is what it is beside a further law: as much of it, needed, and asked for alike by all runs.

    A small cause of the same coordinate may stand beside it. What has another form than what is missing gives way to such a law.
    """
    fits = by_runs.fits
    if name not in larger.names:
        return False
    fitted(fits, larger)
    before, after = (_amounts(fits, e, name) for e in (best, larger))
    moved = (
        np.linalg.norm(after[unit] - old) > fits.settings.partial.differs * np.linalg.norm(old)
        for unit, old in before.items()
    )
    return not any(moved) and _asked_alike(by_runs, larger, name)


def _amounts(fits: ModelFits, hypothesis: Hypothesis, name: str) -> dict[str, np.ndarray]:
    """How much of a name a fit has, by unit: an effect's numbers but those of its form, or by how much a number of the file is off."""
    numbers, found = fits.known(hypothesis).numbers(), dict[str, list[float]]()
    own = name.removeprefix("parameter.")
    if own != name:
        return {"": np.array([numbers[own] - fits.rig.values[own]])}
    for number, p in parameters(BY_NAME[name]).items():
        if not p.of_form:
            found.setdefault(p.unit, []).append(numbers[f"{name}.{number}"])
    return {unit: np.array(values) for unit, values in found.items()}


def _explains_nearly_all(by_runs: ComparisonByRuns, larger: Hypothesis, smaller: Hypothesis) -> bool:
    """Whether a name leaves little of the fitted runs, and of the left-out ones, of which it makes none worse."""
    limits = by_runs.fits.settings.partial
    with_it, without = by_runs.left_out(larger), by_runs.left_out(smaller)
    if any(with_it[run] > limits.harms * without[run] for run in with_it):
        return False
    return all(share < limits.nearly_all for share in _shares(by_runs, larger, smaller))


def _shares(by_runs: ComparisonByRuns, larger: Hypothesis, smaller: Hypothesis) -> tuple[float, float]:
    """Shares of the excess without a name that are left with it [1], of the fitted runs and of the left-out ones."""
    fitted_runs, left_out = (
        _share(by_runs.fits, e(larger), e(smaller)) for e in (by_runs.in_sample.excess, by_runs.left_out.excess)
    )
    return fitted_runs, left_out


def _share(fits: ModelFits, left: float, without: float) -> float:
    """Share of the excess without a name that is left with it [1], infinite where without it there is hardly any."""
    some = fits.settings.search.nothing_left < without < np.inf
    return left / without if some else np.inf


def _differs(part: Amplitude, limits: PartialSettings) -> bool:
    """Whether a part asks for another amplitude."""
    return abs(part.value - 1.0) > max(limits.differs, limits.sigmas * part.error)


def _akin(one: str, other: str) -> bool:
    """Whether two names are laws of one coordinate; what goes with time, as a delay of the readings and a periodic torque, of one part, too."""
    coordinate = coordinate_of(one)
    parts = {name.removeprefix("parameter.").split(".")[0] for name in (one, other)}
    return coordinate == coordinate_of(other) and (coordinate != "time" or len(parts) == 1)


def _further(fits: ModelFits, best: Hypothesis) -> dict[str, tuple[float, Hypothesis]]:
    """Share [1] of what a set leaves that each further name removes, and with which set, of those that were tried; none where nothing is left."""
    excess = ModelComparison(fits).excess
    left, found = excess(best), dict[str, tuple[float, Hypothesis]]()
    if left <= fits.settings.search.nothing_left:
        return found
    for e in fits:
        further = [name for name in e.names if name not in best.names]
        if len(further) == 1 and not is_outside(further[0]) and {*best.names} - {included_in(further[0])} <= {*e.names}:
            share = 1.0 - excess(e) / left
            if further[0] not in found or share > found[further[0]][0]:
                found[further[0]] = share, e
    return found


def further_laws(fits: ModelFits, best: Hypothesis) -> dict[str, float]:
    """Share of what a set leaves that a further name removes, by the name's coordinate; of those that were tried.

    Args:
        fits: fits of the set and of what extends it.
        best: the set.

    Returns:
        By coordinate the largest share of the excess [1]; none where nothing is left to explain.
    """
    found = dict[str, float]()
    for name, (share, _) in _further(fits, best).items():
        coordinate = coordinate_of(name)
        found[coordinate] = max(found.get(coordinate, 0.0), share)
    return found


def _without(fits: ModelFits, best: Hypothesis, name: str) -> Hypothesis:
    """A set without one of its names, or with what this one includes in its place, which the rig file does not model."""
    included, smaller = included_in(name), best.without(name)
    return smaller.plus(included) if included and not models(fits.rig.numbers, included) else smaller


def _apart(hypothesis: Hypothesis, names: Collection[str]) -> Hypothesis:
    """A hypothesis apart from some names."""
    return Hypothesis(tuple(name for name in hypothesis.names if name not in names))


def _rivals(search: FurtherSearch, best: Hypothesis) -> list[Hypothesis] | None:
    """Every other set of no more names that was tried, but its own parts, those near to it at their end; None where it removes too little."""
    if not search.rivals(best) and exchanges(search.candidates, best):
        return None
    fits, excess = search.fits, search.comparison.excess
    tried = [e for e in fits if len(e.names) <= len(best.names) and not {*e.names} <= {*best.names}]
    rivals = [e for e in tried if not e.contains(best)]
    close = 2.0 * fits.settings.partial.as_much * excess(best)
    fits.finish([e for e in rivals if excess(e) < close and not fits.ended(e)])
    return rivals


def _near(search: FurtherSearch, best: Hypothesis, rivals: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The rivals that may stand in the place of a set, those that leave least first; none that is the same thing as the set, and no two that are the same thing.

    They leave about as much, of the fitted runs and of left-out ones, and all their runs ask for as much of what they have of their own.
    """
    excess, same = search.comparison.excess, _same(search, best)
    most = search.fits.settings.partial.as_much * max(excess(best), search.limits.nothing_left)
    near = sorted((e for e in rivals if excess(e) < most and e not in same), key=excess)
    followed = search.by_runs.left_out.excess
    search.by_runs.left_out.prepare(near)
    most = search.fits.settings.partial.as_much * max(followed(best), search.limits.nothing_left)
    near = [e for e in near if followed(e) < most]
    near = [e for e in near if all(_asked_alike(search.by_runs, e, name) for name in _apart(e, best.names).names)]
    known = [e for e in (best, *same, *near) if search.fits.stepped(e)]
    apart = [e for e in near if not any(_moves_as(search.by_runs, e, other) for other in known)]
    return _one_of_each(search, apart, best)


def _one_of_each(search: FurtherSearch, rivals: Sequence[Hypothesis], best: Hypothesis) -> list[Hypothesis]:
    """Of rivals that are the same thing the one that shares most names with a set; in the given order."""
    same, found = {e: _same(search, e) for e in rivals}, list[Hypothesis]()
    for e in sorted(rivals, key=lambda e: -len({*e.names} & {*best.names})):
        if not any(e in same[other] or other in same[e] for other in found):
            found.append(e)
    return [e for e in rivals if e in found]


def _moves_as(compare: ComparisonByRuns, larger: Hypothesis, other: Hypothesis) -> bool:
    """Whether a set makes the rig move as one of fewer numbers does, as a spring without stiffness is a constant torque."""
    fewer = len(compare.fits.known(other).free) < len(compare.fits.known(larger).free)
    return bool(fewer and compare.apart(larger, other) < compare.fits.settings.search.nothing_left)


def _as_likely(fits: ModelFits, named: Hypothesis, rivals: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The simplest of the rivals that are not far less likely than some names, beside a remainder that is an autoregression."""
    if not rivals:
        return []
    fitted(fits, named)
    limits = fits.settings.partial

    def likelihood(e: Hypothesis) -> float:
        return log_likelihood(fits.known(e), fits.train, limits.order)[1]

    least = likelihood(named) - limits.less_likely
    return simplest([e for e in rivals if likelihood(e) > least or not np.isfinite(least)])


def _asked_alike(by_runs: ComparisonByRuns, hypothesis: Hypothesis, name: str) -> bool:
    """Whether a hypothesis needs a name beside a coloured remainder, and all runs ask for as much of it; or it explains nearly all, or most evenly."""
    fits = by_runs.fits
    limits, smaller = fits.settings.partial, _without(fits, hypothesis, name)
    fitted(fits, smaller)
    if _explains_nearly_all(by_runs, hypothesis, smaller):
        return True
    parts = amplitudes(fits, hypothesis, smaller)
    if _explains_most_alike(by_runs, hypothesis, smaller, parts):
        return True
    if not by_runs.in_sample.likelier(hypothesis, smaller):
        return False
    return not any(a.weight >= limits.weighs and _differs(a, limits) for a in parts)


def _beside(
    search: FurtherSearch, named: Hypothesis, near: Sequence[Hypothesis], rivals: Sequence[Hypothesis]
) -> Claim:
    """The claim of names that hold, with what may stand in their place; first what was fitted.

    Beside it the best name of each coordinate is fitted: that which removes most says where what is left lies.
    """
    for e in (named, *near):
        fitted(search.fits, e)
    further = extensions(_best_of_each_coordinate(search), named)
    search.halving.fit([e for e in further if not search.fits.stepped(e)], named)
    same = _same(search, named)
    beside = dict.fromkeys([*near, *same, *(e for one in near for e in _same(search, one))])
    return Claim(named, tuple(e for e in beside if e != named and not e.contains(named)), tuple(same), tuple(rivals))


def _best_of_each_coordinate(search: FurtherSearch) -> list[str]:
    """The name of every coordinate that leaves least beside the rig as it is."""
    singles = [e for e in extensions(search.candidates, NOTHING) if search.fits.stepped(e)]
    best: dict[str, str] = {}
    for e in sorted(singles, key=lambda e: search.fits.known(e).cost):
        best.setdefault(coordinate_of(e.names[0]), e.names[0])
    return list(best.values())


def _same(search: FurtherSearch, hypothesis: Hypothesis) -> list[Hypothesis]:
    """What is the same thing as a set for this kind of rig, with any of its names exchanged."""
    found = [hypothesis]
    for one in found:
        found += [e for e in equivalents(search.fits, search.candidates, one) if e not in found]
    return found[1:]
