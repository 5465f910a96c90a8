"""The answer so far: what a search that the budget has ended may say, which is no choice."""

from collections.abc import Sequence

import numpy as np

from rwjax.diagnosis.hypothesis import NOTHING
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.neighbours import extensions


def so_far(fits: ModelFits, candidates: Sequence[str]) -> Choice:
    """What leads among the fits that a search has come to.

    Args:
        fits: the rig's fits, and those that the search has begun.
        candidates: names that might be missing.

    Returns:
        The leader with the ranking, as a choice that is not complete.
    """
    compare = ModelComparison(fits)
    seen = [e for e in fits if e.names and (e in fits.headway.compared or fits.stepped(e))]  # from some places at least
    begun = [e for e in seen if np.isfinite(fits.known(e).cost)]
    best = compare.leader([NOTHING, *begun])
    effective = compare.effective(best)
    base = compare.criterion(NOTHING, effective)
    singles = extensions(candidates, NOTHING)
    ranked = [e for e in dict.fromkeys([*singles, best, NOTHING]) if e in begun or not e.names]
    return Choice(
        best,
        criterion={e: compare.criterion(e, effective) - base for e in (NOTHING, *begun)},
        ranking=compare.probabilities(ranked, effective),
        complete=False,
        untried=tuple(name for e in singles if e not in fits.headway.compared and e not in begun for name in e.names),
    )
