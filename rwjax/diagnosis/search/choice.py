"""Choice: what a search says of the training logs."""

from dataclasses import dataclass, field

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis


@dataclass(frozen=True)
class Choice:
    """The hypothesis that a search has chosen, and those beside it.

    Attributes:
        best: the chosen hypothesis; one without names says that nothing is missing.
        alternatives: hypotheses that cannot be told apart from the best one.
        equivalents: those of the alternatives that no logs of this kind of rig can tell apart.
        criterion: information criterion of every hypothesis that was tried, relative to the rig as it is; larger is better.
        ranking: single names, the best set and the rig as it is, each with its probability among these; the most probable first.
        complete: whether the search came to its end; one that did not claims nothing.
        untried: single names that were then not compared.
    """

    best: Hypothesis
    alternatives: tuple[Hypothesis, ...] = ()
    equivalents: tuple[Hypothesis, ...] = ()
    criterion: dict[Hypothesis, float] = field(default_factory=dict)
    ranking: tuple[tuple[Hypothesis, float], ...] = ()
    complete: bool = True
    untried: tuple[str, ...] = ()

    @classmethod
    def nothing(cls) -> "Choice":
        """The choice of the rig as it is, without a search.

        Returns:
            The choice, with nothing tried.
        """
        return cls(NOTHING, criterion={NOTHING: 0.0}, ranking=((NOTHING, 1.0),))
