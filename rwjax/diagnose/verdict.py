"""The verdict, from the gap on held-out logs and the choice made on the training logs."""

from typing import Literal

from rwjax.diagnose.gap import Gap
from rwjax.diagnose.search import Choice

Verdict = Literal["none", "effect", "ambiguous", "unknown"]

SIZE_OF_NOTHING = 1.0
"""Size of a gap, in floors, below which nothing is said to be missing."""
SIZE_OF_DOUBT = 1.75
r"""Size of a gap, in floors, below which a gap that nothing explains is not claimed: the first angle of a run that
starts between two counts is off by up to half a count, $\sqrt3$ times its noise, which the floor does not hold."""
EXPLAINED = 0.8
"""Share of the gap above the floor that must be closed for the effects to explain it; a closure whose 95 % interval
lies below it does not."""
BARELY = 0.6
"""Share of the gap that a named cause closes at the least, however wide its interval."""
AT_FLOOR = 1.25
"""Error after the effects are added, in floors, that counts as reaching the floor."""


def stands_out(gap: Gap) -> bool:
    """Whether a gap of the rig as it is asks for an explanation."""
    return gap.closed is not None and gap.size >= SIZE_OF_NOTHING


def judge(choice: Choice, gap: Gap) -> Verdict:
    """One of the four outcomes for the headline signal.

    A gap that is surely closed to less than `EXPLAINED` and still stands above the floor has a cause that the library does not
    know, or several, and the names that help must not be taken for it.
    """
    if not stands_out(gap):
        return "none"
    if not choice.best.names:
        return "none" if gap.size < SIZE_OF_DOUBT else "unknown"
    short = gap.closed < BARELY or (gap.ci95 is not None and gap.ci95[1] < EXPLAINED)
    if short and gap.after > AT_FLOOR * gap.floor:
        return "unknown"
    return "ambiguous" if choice.alternatives else "effect"
