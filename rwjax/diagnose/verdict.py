"""The verdict, from the gap on held-out logs and the choice made on the training logs."""

from typing import Literal

from rwjax.diagnose.gap import Gap
from rwjax.diagnose.search import Choice
from rwjax.diagnose.thresholds import AT_FLOOR, BARELY, EXPLAINED, SIZE_OF_DOUBT, SIZE_OF_NOTHING

Verdict = Literal["none", "effect", "ambiguous", "unknown"]


def stands_out(gap: Gap) -> bool:
    """Whether a gap of the rig as it is asks for an explanation."""
    return gap.closed is not None and gap.size >= SIZE_OF_NOTHING


def judge(choice: Choice, gap: Gap) -> Verdict:
    """One of the four outcomes for the headline signal.

    A gap that is surely closed to less than `EXPLAINED` and still stands above the floor has a cause that the library does not
    know, or several, and the names that help must not be taken for it.
    """
    if gap.closed is None or not stands_out(gap):
        return "none"
    if not choice.best.names:
        return "none" if gap.size < SIZE_OF_DOUBT else "unknown"
    short = gap.closed < BARELY or (gap.ci95 is not None and gap.ci95[1] < EXPLAINED)
    if short and gap.after > AT_FLOOR * gap.floor:
        return "unknown"
    return "ambiguous" if choice.alternatives else "effect"
