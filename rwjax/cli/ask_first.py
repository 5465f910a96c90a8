"""Questions that a command asks before its work begins, and how a user goes on in spite of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.logs.log import Log
    from rwjax.rig.model import Rig

GO_ON = "`--force` goes on even so"
Force = Annotated[bool, typer.Option("--force", help="go on in spite of questions about the logs")]


class Asked(NamedTuple):
    """What was found before a command's work began.

    Attributes:
        questions: The questions that the user leaves open.
        missing: Which logs lack rows, few or many in a row: nothing to be answered, and to be known beside the result.
    """

    questions: list[str]
    missing: list[str]

    @property
    def notes(self) -> list[str]:
        """All of it, the questions first."""
        return [*self.questions, *self.missing]


def ask_first(rig: "Rig", logs: "Sequence[Log]", force: bool) -> Asked:
    """Asks about logs that contradict the rig file as a mistake would make them.

    Args:
        rig: the rig.
        logs: the logs.
        force: whether the user goes on in spite of questions.

    Returns:
        What is to be noted beside the result.

    Raises:
        InputError: there are questions; the message holds them all.
    """
    from rwjax.fitting.questions.ask import questions
    from rwjax.logs.findings import holes

    found = questions(rig, logs)
    if found and not force:
        raise InputError("; ".join([*found, GO_ON]))
    return Asked([*found], holes(logs))
