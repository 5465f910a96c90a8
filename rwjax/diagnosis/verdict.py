"""The verdict, from the gap on held-out logs and the choice made on the training logs."""

from typing import Literal

from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.search.forward_backward import Choice
from rwjax.diagnosis.settings import VERDICT, Limits

Verdict = Literal["none", "effect", "ambiguous", "unknown"]


def stands_out(gap: Gap) -> bool:
    """Whether a gap of the rig as it is asks for an hypothesis."""
    return gap.closed is not None and gap.size >= VERDICT.nothing


def judge(choice: Choice, gap: Gap) -> Verdict:
    """One of the four outcomes for the headline signal."""
    return verdict(len(choice.best.names), bool(choice.alternatives), gap, VERDICT)


def verdict(names: int, rivals: bool, gap: Gap, limits: Limits) -> Verdict:
    """The outcome where the search has found some `names`, with or without `rivals`.

    A gap that is surely closed to less than `limits.explained` and still stands above the floor has a cause that the library
    does not know, or several, and the names that help must not be taken for it. Several names together can imitate much: they must
    close nearly all of it.
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
