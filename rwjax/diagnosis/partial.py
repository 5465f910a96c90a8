"""What holds of an explanation that leaves a visible part: which of its names may be claimed under `partial`.

Everything is decided on training runs. A name holds where

* every run, and commands of every size, ask for as much of it (`rwjax.diagnosis.agreement`), and runs that were left out are followed
  better with it than without;
* no free-form law of its coordinate explains what it leaves, by the missing torque (`rwjax.diagnosis.localise.law`) and by free runs,
  in which the library's other laws of the coordinate stand for it; what it leaves lies nearest to a law of another coordinate;
* it is needed beside a remainder that is coloured noise: by the information criterion with the fewer independent readings of those that
  both residuals allow;
* its rivals leave clearly more in proportion to what it leaves. Rivals that leave about as much stand beside it as alternatives. Where
  they are many, nothing is claimed.

A set of names holds where each of them does.
"""

from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.agreement import amplitudes, left_out
from rwjax.diagnosis.hypothesis import Hypothesis, coordinate_of
from rwjax.diagnosis.localise.law import law_left
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.equivalents import equivalents
from rwjax.diagnosis.search.forward_backward import Search
from rwjax.diagnosis.search.successive_halving import fitted
from rwjax.effects.library import included_in, models


class Claim(NamedTuple):
    """Names that hold, though they leave something.

    Attributes:
        named: the named set.
        alternatives: the sets of which one may stand in its place.
        equivalents: those of the alternatives that no logs of this kind of rig can tell apart from it.
    """

    named: Hypothesis
    alternatives: tuple[Hypothesis, ...]
    equivalents: tuple[Hypothesis, ...]


def claimed(search: Search, choice: Choice) -> Claim | None:
    """The largest part of an explanation that holds.

    Args:
        search: the search that has found it.
        choice: the explanation, with a fit at its end; where it reaches the noise, the evidence says what stands beside it.

    Returns:
        The claim, None where nothing holds.
    """
    best = choice.best
    while best.names:
        fitted(search.fits, best)
        fails = [name for name in best.names if why_not_held(search.fits, best, name) is not None]
        if not fails and best == choice.best and search.comparison.excess(best) <= search.limits.nothing_left:
            return Claim(best, choice.alternatives, choice.equivalents)
        if not fails:
            return _beside_rivals(search, best)
        best = best.without(fails[-1])
    return None


def why_not_held(fits: ModelFits, best: Hypothesis, name: str) -> str | None:
    """Why a name may not be claimed.

    Args:
        fits: a fit of the set at its end.
        best: the set.
        name: one of its names.

    Returns:
        The first test that it fails, in words; None where it holds.
    """
    limits, smaller = fits.settings.partial, _without(fits, best, name)
    fitted(fits, smaller)
    if _gain(fits, best, smaller) <= limits.needed:
        return "it is not needed beside a remainder that is coloured noise"
    parts = [a for a in amplitudes(fits, best, smaller) if a.weight >= limits.weighs]
    if any(abs(a.value - 1.0) > max(limits.differs, limits.sigmas * a.error) for a in parts):
        return "runs or sizes of the command ask for different amounts of it"
    if any(a.error > limits.differs for a in parts):
        return "some runs or sizes of the command do not tell how much of it they ask for"
    followed = left_out(fits, (best, smaller))
    if len(followed[best]) < limits.runs:
        return "too few runs tell whether it is the same in each"
    if np.any(followed[best] > limits.harms * followed[smaller]):
        return "a run that is left out is followed worse with it"
    left = law_left(fits, best, smaller, name)
    if left is not None and left > limits.law_left:
        return "a free-form law of its coordinate explains more"
    laws = further_laws(fits, best)
    own = laws.get(coordinate_of(name), 0.0)
    if own > limits.further_law:
        return "a further law of its coordinate removes part of what it leaves"
    if own > fits.settings.search.first_removes and own >= max(laws.values()):
        return "what it leaves is nearest to a further law of its own coordinate"
    return None


def further_laws(fits: ModelFits, best: Hypothesis) -> dict[str, float]:
    """Share of what a set leaves that a further name removes, by the name's coordinate; of those that were tried.

    Args:
        fits: fits of the set and of what extends it.
        best: the set.

    Returns:
        By coordinate the largest share of the excess [1]; none where nothing is left to explain.
    """
    excess = ModelComparison(fits).excess
    left, found = excess(best), dict[str, float]()
    if left <= fits.settings.search.nothing_left:
        return found
    for e in fits:
        if e.contains(best) and len(e.names) <= len(best.names) + 1:
            for name in {*e.names} - {*best.names}:
                coordinate = coordinate_of(name)
                found[coordinate] = max(found.get(coordinate, 0.0), 1.0 - excess(e) / left)
    return found


def _without(fits: ModelFits, best: Hypothesis, name: str) -> Hypothesis:
    """A set without one of its names, or with what this one includes in its place, which the rig file does not model."""
    included, smaller = included_in(name), best.without(name)
    return smaller.plus(included) if included and not models(fits.rig.numbers, included) else smaller


def _gain(fits: ModelFits, larger: Hypothesis, smaller: Hypothesis) -> float:
    """Gain of the larger set in the information criterion [1], with the fewer independent readings of both residuals."""
    compare = ModelComparison(fits)
    one, other = compare.effective(larger), compare.effective(smaller)
    effective = {name: min(one[name], other[name]) for name in one}
    return compare.criterion(larger, effective) - compare.criterion(smaller, effective)


def _beside_rivals(search: Search, best: Hypothesis) -> Claim | None:
    """The claim of a set whose names hold, None where it does not stand out among its rivals."""
    excess, limits = ModelComparison(search.fits).excess, search.fits.settings.partial
    rivals = [e for e in search.rivals(best) if len(e.names) <= len(best.names) and not e.contains(best)]
    if not rivals:
        return None
    near = [e for e in rivals if excess(e) < limits.as_much * excess(best)]
    near = [e for e in near if not any(e.contains(other) for other in near)]
    if len(near) > limits.alternatives:
        return None
    near.sort(key=excess)
    same = equivalents(search.fits, search.candidates, best)
    also = [e for one in near for e in equivalents(search.fits, search.candidates, one)]
    return Claim(best, tuple(e for e in dict.fromkeys([*near, *same, *also]) if e != best), tuple(same))
