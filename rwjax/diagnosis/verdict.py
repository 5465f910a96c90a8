"""The verdict, from the gap on held-out logs and the choice made on the training logs."""

from typing import Literal

from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.settings import Limits

Verdict = Literal["none", "effect", "ambiguous", "unknown"]


def stands_out(gap: Gap, limits: Limits) -> bool:
    """Whether a gap of the rig as it is asks for a hypothesis.

    Args:
        gap: the gap before any effect is added.
        limits: limits of the verdict.

    Returns:
        True where it stands above its floor by enough.
    """
    return gap.closed is not None and gap.size >= limits.nothing


def judge(choice: Choice, gap: Gap, limits: Limits) -> Verdict:
    """The outcome for the headline signal; a choice that is not complete claims nothing.

    Args:
        choice: what the search has chosen.
        gap: the gap of the headline signal on held-out logs.
        limits: limits of the verdict.

    Returns:
        One of the four outcomes.
    """
    if not choice.complete:
        return "unknown"
    return verdict(len(choice.best.names), bool(choice.alternatives), gap, limits)


def verdict(names: int, rivals: bool, gap: Gap, limits: Limits) -> Verdict:
    """The outcome where a search has found some names, with or without rivals.

    A gap may surely be closed to less than `limits.explained` and still stand above the floor. It then has a cause that the library
    does not know, or several, and the names that help must not be taken for it. Several names together can imitate much, so they
    must close nearly all of the gap.

    Args:
        names: how many names were chosen.
        rivals: whether other hypotheses cannot be told apart from the chosen one.
        gap: the gap of the headline signal on held-out logs.
        limits: limits of the verdict.

    Returns:
        One of the four outcomes.
    """
    if gap.closed is None or gap.size < limits.nothing:
        return "none"
    if not names:
        return "none" if gap.size < limits.doubt else "unknown"
    least = limits.several if names > 1 else limits.barely
    short = gap.closed < least or (gap.ci95 is not None and gap.ci95[1] < limits.explained)
    if short and gap.after > limits.at_floor * gap.floor:
        return "unknown"
    return "ambiguous" if rivals else "effect"
