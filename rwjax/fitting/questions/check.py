"""All that can be said about logs before any fit: by themselves, against the rig file, and of its free numbers."""

from collections.abc import Sequence

from rwjax.fitting.questions.ask import questions
from rwjax.fitting.questions.guesses import about_guesses
from rwjax.fitting.questions.numbers import NothingTold, about_numbers
from rwjax.fitting.segments import with_segments
from rwjax.logs.dropouts import dropouts, without_dropouts
from rwjax.logs.findings import Finding, findings
from rwjax.logs.log import Log
from rwjax.rig.model import Rig


def check(rig: Rig, logs: Sequence[Log]) -> list[Finding]:
    """What is odd about logs, before any fit.

    Args:
        rig: The rig.
        logs: The logs, at least one.

    Returns:
        Findings, those first that would stop a fit ("units").
    """
    logs = with_segments(rig, logs)
    read = [log for log in logs if log.outputs]
    asked = questions(rig, read) if read else []
    train = [log for log in logs if not log.validate] or list(logs)
    # of logs that may be in other units, nothing can be said of numbers
    told = [] if asked else about_numbers(rig, [without_dropouts(log, dropouts(log)) for log in train])
    return [
        *(Finding("", "units", str(question), "question") for question in asked),
        *(finding for log in logs for finding in findings(log) if str(finding) not in asked),
        *(Finding("", "numbers", says, "guessed") for says in about_guesses(rig)),
        *(
            Finding("", "numbers", says, "nothing_told" if isinstance(says, NothingTold) else "barely_told")
            for says in told
        ),
    ]
