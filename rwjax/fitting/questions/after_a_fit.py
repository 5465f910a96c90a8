"""Questions that only a fit can ask: where numbers are guesses, a free run with them tells little of a log's sign or unit.

The free numbers are fitted to the logs as they are, and to the same logs without a mistake that users make. Numbers bend, but no
number of a rig turns a command over, or makes a weight pull by an angle in degrees.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.questions.angles import from_wide_degrees
from rwjax.fitting.questions.free_runs import free_runs
from rwjax.fitting.questions.likeness import AS_IT_IS, Question, Run, explained, names_of, plainly_better
from rwjax.fitting.questions.own_numbers import at_own_numbers
from rwjax.fitting.segments import with_segments
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.kinds import GOAL
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

STEPS = 20
"""Steps of each fit at most [1]: a mistake leaves most of the motion, so that coming near is enough."""
MOST_SAMPLES = 20_000
"""Samples up to which logs are fitted, the first of them: more tell nothing more of a mistake that all logs have [1]."""


def about_what_a_fit_leaves(rig: Rig, logs: Sequence[Log]) -> list[Question]:
    """A question about the command's sign, or about angles in degrees, where a fit follows the logs in that way alone.

    Args:
        rig: The rig with its free numbers.
        logs: The logs; those marked for validation are left out.

    Returns:
        The question; none where the file's numbers or a fit follow some log as it is, or of servos, which have questions of their own.

    Raises:
        LogError: The logs have several commands.
    """
    logs = _some([log for log in with_segments(rig, logs) if log.outputs and not log.validate])
    if any(log.input == GOAL for log in logs):
        return []
    runs = _followed(rig, logs)
    shares = [explained(run) for run in runs]
    if max(shares, default=1.0) >= AS_IT_IS:
        return []
    for without, what, asks in WAYS:
        if all(without(log) is log for log in logs):
            continue
        better = [explained(run) for run in _followed(rig, [without(log) for log in logs])]
        pairs = [*zip(runs, shares, better, strict=True)] if better else []
        plain = [run.log for run, own, other in pairs if plainly_better(own, other)]
        if 2 * len(plain) > len(runs) and all(other > own for _, own, other in pairs):
            left = f"as it is, a fit leaves {_left(shares)} of the motion"
            return [Question(f"{names_of(plain)}: {left}, and with {what} it follows the motion: {asks}")]
    return []


def turned_over(log: Log) -> Log:
    """A log whose command has the other sign.

    Args:
        log: The log.

    Returns:
        The same, its command turned over.
    """
    return replace(log, command=-log.command, earlier=(log.earlier[0], -log.earlier[1]))


WAYS: tuple[tuple[Callable[[Log], Log], str, str], ...] = (
    (
        turned_over,
        "the command's sign turned over",
        "is its sign wrong, or that of all readings? Write `NAME = { sign = -1 }` for it under [columns]",
    ),
    (
        from_wide_degrees,
        "angles taken for degrees",
        'are the readings in degrees? Write `NAME = { unit = "deg" }` for them under [columns], or divide them by 57.296',
    ),
)
"""Logs without a mistake, what was done to them, and what is asked where a fit follows them plainly better."""


def _some(logs: Sequence[Log]) -> list[Log]:
    """The first logs, until they hold enough samples."""
    before = np.cumsum([0, *(len(log.time) for log in logs)])[: len(logs)]
    return [log for log, samples in zip(logs, before, strict=True) if samples < MOST_SAMPLES]


def _followed(rig: Rig, logs: Sequence[Log]) -> list[Run]:
    """The logs that are read with the free runs of a fit, or of the file's numbers where these suffice; none where none can be fitted."""
    here = at_own_numbers(rig, logs) if logs else None
    if here is None:
        return []
    runs = _runs(here)
    if max((explained(run) for run in runs), default=1.0) >= AS_IT_IS:
        return runs
    nodes = measured_nodes(here.problem, here.theta)
    return _runs(least_squares(here.problem, here.coordinates, here.theta, nodes=nodes, most_steps=STEPS))


def _runs(fit: Fit) -> list[Run]:
    """The logs that are read, with a fit's free runs."""
    return free_runs(fit.problem, fit.theta, fit.problem.batch, fit.start)


def _left(shares: Sequence[float]) -> str:
    """What free runs leave of the motion, the mean over the logs, in words."""
    left = 100.0 * (1.0 - float(np.mean(shares)))
    return "all" if left >= 99.5 else f"{left:.0f} %"
