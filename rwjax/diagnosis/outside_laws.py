"""Laws outside the list of effects: names that pass for one of them are not claimed where it does as well in their place."""

from rwjax.diagnosis.exact_fits import fit_exactly
from rwjax.diagnosis.hypothesis import Hypothesis, spoken
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from rwjax.effects.library import passing_for


def with_outside_laws(fits: ModelFits, named: Hypothesis) -> dict[str, Hypothesis]:
    """Names of a set in whose place a law outside the list does as well, beside the others.

    Such a law is one of many of its kind. So it need not have as good an information criterion, but one that comes near.

    Args:
        fits: fits to the training logs; that of the set is at its end.
        named: the set.

    Returns:
        For each such name the set with the law in its place, with a fit at its end.
    """
    compare, found = ModelComparison(fits), dict[str, Hypothesis]()
    near = fits.settings.search.close_outside
    for name in named.names:
        for law in passing_for(name):
            instead = named.without(name).plus(law)
            fits.headway.enter([instead], "a law outside the list", besides=fits.settings.headway.exact, further=0.0)
            fits.keep(SuccessiveHalving(fits).from_all_places([instead], named))
            fit_exactly(fits, [instead])
            fits.finish([instead])
            if compare.gain(instead, named) > -near:
                found[name] = instead
    return found


def why_not_claimed(named: Hypothesis, instead: Hypothesis) -> str:
    """Why a name is not claimed in whose place a law outside the list does as well.

    Args:
        named: the set with the name.
        instead: the set with the law.

    Returns:
        The reason in words.
    """
    law = next(name for name in instead.names if name not in named.names)
    return f"{spoken(law)} does as well in its place, and is no effect of the list"
