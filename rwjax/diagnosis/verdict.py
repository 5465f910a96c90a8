"""The verdict, from the gap on held-out logs and the choice made on the training logs."""

from collections.abc import Mapping
from typing import Literal

import numpy as np

from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.settings import Limits, Settings

Verdict = Literal["none", "effect", "ambiguous", "partial", "unknown"]
CLAIMS: tuple[Verdict, ...] = ("effect", "ambiguous", "partial")
"""Verdicts under which a name is a claim."""


def stands_out(gap: Gap, limits: Limits) -> bool:
    """Whether a gap of the rig as it is asks for a hypothesis.

    Args:
        gap: the gap before any effect is added.
        limits: limits of the verdict.

    Returns:
        True where it stands above its floor by enough.
    """
    return gap.closed is not None and gap.size >= limits.nothing


def leaves_a_visible_part(gap: Gap, limits: Limits) -> bool:
    """Whether what the named effects leave asks for a further explanation, as a gap of its own would.

    Args:
        gap: the gap of an output on held-out logs.
        limits: limits of the verdict.

    Returns:
        True where it stands above the floor by as much, however small a share of the gap it is.
    """
    return bool(np.sqrt(max(gap.after**2 - gap.floor**2, 0.0)) >= limits.doubt * gap.floor)


def left_elsewhere(gaps: Mapping[str, Gap], signal: str, limits: Limits) -> str | None:
    """The output that the named effects do not explain where they explain that of the headline.

    Args:
        gaps: the gap on held-out logs by output.
        signal: the headline signal.
        limits: limits of the verdict.

    Returns:
        Of the outputs that keep a visible part the one that stays most floors from its floor; None where the headline keeps one, or none does.
    """
    visible = [name for name, gap in gaps.items() if leaves_a_visible_part(gap, limits)]
    return (
        None if signal in visible else max(visible, key=lambda name: gaps[name].after / gaps[name].floor, default=None)
    )


def closes_in_part(gap: Gap, limits: Settings, *, followed: bool) -> bool:
    """Whether names that hold close enough of the gap to be claimed though they leave a visible part.

    Names that leave a part of the held-out runs alone follow the fitted runs better than others. They have to close as much as a whole
    answer does.

    Args:
        gap: the gap of the headline signal on held-out logs, which judge but do not choose.
        limits: limits of the diagnosis.
        followed: whether the names leave no visible part of the runs that they were fitted to.

    Returns:
        True where they do.
    """
    return gap.closed is not None and gap.closed >= (limits.verdict.barely if followed else limits.partial.closes)


def judge(choice: Choice, gaps: Mapping[str, Gap], signal: str, limits: Limits) -> Verdict:
    """The outcome for the headline signal; a choice that is not complete claims nothing.

    Where another output keeps a visible part, names are not the whole answer, either.

    Args:
        choice: what the search has chosen.
        gaps: the gap on held-out logs by output.
        signal: the headline signal.
        limits: limits of the verdict.

    Returns:
        One of the outcomes but `partial`, of which more has to be known.
    """
    if not choice.complete:
        return "unknown"
    outcome = verdict(len(choice.best.names), bool(choice.alternatives), gaps[signal], limits)
    return "unknown" if outcome in CLAIMS and left_elsewhere(gaps, signal, limits) else outcome


def verdict(names: int, rivals: bool, gap: Gap, limits: Limits) -> Verdict:
    """The outcome where a search has found some names, with or without rivals.

    A gap may surely be closed to less than `limits.explained` and still stand above the floor. It then has a cause that the library
    does not know, or several, and the names that help must not be taken for it. Several names together can imitate much, so they
    must close nearly all of the gap. Where a visible part is left, no name is the whole answer.

    Args:
        names: how many names were chosen.
        rivals: whether other hypotheses cannot be told apart from the chosen one.
        gap: the gap of the headline signal on held-out logs.
        limits: limits of the verdict.

    Returns:
        One of the outcomes but `partial`.
    """
    if gap.closed is None or gap.size < limits.nothing:
        return "none"
    if not names:
        return "none" if gap.size < limits.doubt else "unknown"
    least = limits.several if names > 1 else limits.barely
    short = gap.closed < least or (gap.at_most is not None and gap.at_most < limits.explained)
    if (short and gap.after > limits.at_floor * gap.floor) or leaves_a_visible_part(gap, limits):
        return "unknown"
    return "ambiguous" if rivals else "effect"
