"""Sets of names that are the same thing as a chosen one for a kind of rig, whatever the logs."""

from collections.abc import Mapping, Sequence

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.effects.effect import FittedRig
from rwjax.effects.library import included_in, models, of_kind, same_groups
from rwjax.rig.model import Rig


def equivalents(fits: ModelFits, candidates: Sequence[str], best: Hypothesis) -> list[Hypothesis]:
    """Hypotheses that are the same thing as `best` for this kind of rig, whatever the logs.

    Args:
        fits: the rig's fits.
        candidates: names that might be missing.
        best: the chosen hypothesis.

    Returns:
        The hypotheses, each with one member of `best` exchanged. Where no fit of `best` has begun, those that do not go by its numbers.
    """
    rig, numbers = fits.rig, fits.known(best).numbers() if best in fits else {}
    as_fitted = FittedRig(rig.kind, frozenset({*best.names, *rig.effects}), numbers)
    found = []
    for group in [*same_groups(as_fitted), *_larger(rig, best, numbers)]:
        same = [name for name in group if name in candidates]
        members = [name for name in best.names if name in same]
        if len(members) == 1:
            found += [e for name in same if (e := _instead(rig, best, members[0], name)) not in (best, None)]
    return found


def _larger(rig: Rig, best: Hypothesis, fitted: Mapping[str, float]) -> list[list[str]]:
    """Numbers that `best` frees and that were fitted larger than the rig file says, each with the effects that it may be."""
    effects = of_kind(rig.kind).items()
    return [
        [f"parameter.{number}", name]
        for number in best.numbers
        for name, effect in effects
        if number in effect.like_larger and fitted.get(number, rig.numbers[number]) > rig.numbers[number]
    ]


def _instead(rig: Rig, best: Hypothesis, member: str, name: str) -> Hypothesis | None:
    """`best` with a name in the place of a member.

    Where only one of both includes dry friction (as direction-dependent friction does), the other is the same thing
    only beside dry friction of its own: that is added or taken away along. None where there is none to take away.
    """
    other = best.without(member).plus(name)
    before, after = included_in(member), included_in(name)
    if before == after or models(rig.numbers, before or after):
        return other
    if before:
        return other.plus(before)
    return other.without(after) if after in best.names else None
