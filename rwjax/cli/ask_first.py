"""Questions that a command asks before its work begins, and how a user goes on in spite of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.logs.log import Log
    from rwjax.rig.model import Rig

GO_ON = "`--force` goes on even so"
Force = Annotated[bool, typer.Option("--force", help="go on in spite of questions about the logs")]


def ask_first(rig: "Rig", logs: "Sequence[Log]", force: bool) -> list[str]:
    """Asks about logs that contradict the rig file as a mistake would make them.

    Args:
        rig: the rig.
        logs: the logs.
        force: whether the user goes on in spite of questions.

    Returns:
        What is to be noted beside the result: the questions that the user leaves open, and which logs miss rows.

    Raises:
        InputError: there are questions; the message holds them all.
    """
    from rwjax.fitting.questions.ask import questions
    from rwjax.logs.findings import missing_rows

    found = questions(rig, logs)
    if found and not force:
        raise InputError("; ".join([*found, GO_ON]))
    return [*found, *(str(finding) for log in logs for finding in missing_rows(log))]
