"""Neighbours of a hypothesis: those with one name more, and those with one name exchanged."""

from collections.abc import Sequence

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.effects.library import included_in


def extensions(candidates: Sequence[str], hypothesis: Hypothesis) -> list[Hypothesis]:
    """Hypotheses with one name more.

    An effect that includes another one takes its place, and the included effect is not added to it.

    Args:
        candidates: names that might be missing.
        hypothesis: the hypothesis to extend.

    Returns:
        One hypothesis for each further name, in the order of the candidates.
    """
    found = []
    for name in candidates:
        if name not in hypothesis.names and name not in map(included_in, hypothesis.names):
            found.append(hypothesis.without(included_in(name)).plus(name))
    return found


def exchanges(candidates: Sequence[str], hypothesis: Hypothesis) -> list[Hypothesis]:
    """Hypotheses with one member exchanged for another name.

    A member that includes another effect is also exchanged for that effect and another name.

    Args:
        candidates: names that might be missing.
        hypothesis: the hypothesis whose members are exchanged.

    Returns:
        The hypotheses, each once, without the given one.
    """
    found = []
    for member in hypothesis.names:
        included = included_in(member)
        rest = hypothesis.without(member)
        bare = [rest.plus(name) for name in candidates if name not in hypothesis.names]
        found += bare
        if included in candidates:  # which are what the rig file does not model
            found += [e.plus(included) for e in bare if included not in map(included_in, e.names)]
    return [e for e in dict.fromkeys(found) if e != hypothesis]
