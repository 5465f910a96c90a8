"""Laws outside the list of effects: names that pass for one of them are not claimed where it does as well in their place."""

from collections.abc import Sequence
from typing import NamedTuple

from rwjax.diagnosis.exact_fits import fit_exactly
from rwjax.diagnosis.hypothesis import Hypothesis, spoken
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving, fitted
from rwjax.effects.library import passing_for


class OutsideLaw(NamedTuple):
    """A law outside the list in the place of a name.

    Attributes:
        name: the name.
        law: the law.
        of: the set that holds the name.
        instead: the same set with the law in its place.
    """

    name: str
    law: str
    of: Hypothesis
    instead: Hypothesis

    @property
    def why(self) -> str:
        """Why the name is not claimed where the law does as well, in words."""
        return f"{spoken(self.law)} does as well in its place, and is no effect of the list"


def outside_laws_of(named: Sequence[Hypothesis]) -> list[OutsideLaw]:
    """The laws outside the list that pass for a name of some sets.

    Args:
        named: the sets.

    Returns:
        Each law with the name for which it passes.
    """
    every = ((e, name, law) for e in named for name in e.names for law in passing_for(name))
    return [OutsideLaw(name, law, e, e.without(name).plus(law)) for e, name, law in every]


def doing_as_well(fits: ModelFits, asked: Sequence[OutsideLaw]) -> list[OutsideLaw]:
    """Those of some laws that do as well as the names for which they pass, beside the other names of their sets.

    Such a law is one of many of its kind. So it need not have as good an information criterion, but one that comes near.

    Args:
        fits: fits to the training logs, in which the sets have begun.
        asked: the laws.

    Returns:
        Those that do as well.
    """
    compare, near = ModelComparison(fits), fits.settings.search.close_outside
    fits.headway.enter(
        [one.instead for one in asked], "laws outside the list", besides=fits.settings.headway.exact, further=0.0
    )
    found = []
    for one in asked:
        fitted(fits, one.of)
        fits.keep(SuccessiveHalving(fits).from_all_places([one.instead], one.of))
        fit_exactly(fits, [one.instead])
        fits.end([one.instead])
        if compare.gain(one.instead, one.of) > -near:
            found.append(one)
    return found
