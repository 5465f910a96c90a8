"""Questions that only a fit can ask: where numbers are guesses, a free run with them tells little of a log's sign or unit.

The free numbers are fitted to the logs as they are, and to the same logs without a mistake that users make. Numbers bend, but no
number of a rig turns a command over, or makes a weight pull by an angle in degrees.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.questions.angles import from_degrees
from rwjax.fitting.questions.free_runs import free_runs
from rwjax.fitting.questions.likeness import AS_IT_IS, Question, explained, names_of, plainly_better
from rwjax.fitting.questions.own_numbers import at_own_numbers
from rwjax.fitting.segments import with_segments
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.kinds import GOAL
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

STEPS = 20
"""Steps of each fit at most: enough to come near where a mistake leaves most of the motion [1]."""


def about_what_a_fit_leaves(rig: Rig, logs: Sequence[Log]) -> list[Question]:
    """A question about the command's sign, or about angles in degrees, where a fit follows the logs in that way alone.

    Args:
        rig: The rig with its free numbers.
        logs: The logs.

    Returns:
        The question; none where the file's numbers or a fit follow some log as it is, or of servos, which have questions of their own.
    """
    logs = [log for log in with_segments(rig, logs) if log.outputs]
    if any(log.input == GOAL for log in logs) or not (shares := _followed(rig, logs)) or max(shares) >= AS_IT_IS:
        return []
    for without, what, asks in WAYS:
        other = _followed(rig, [without(log) for log in logs])
        pairs = [*zip(shares, other, strict=True)] if other else []
        plain = [log for log, (own, better) in zip(logs, pairs, strict=False) if plainly_better(own, better)]
        if 2 * len(plain) > len(logs) and all(better > own for own, better in pairs):
            leaves = (f"{100.0 * (1.0 - float(np.mean(some))):.2g} %" for some in (other, shares))
            left, as_it_is = leaves
            return [
                Question(f"{names_of(plain)}: a fit leaves {as_it_is} of the motion, and {left} with {what}: {asks}")
            ]
    return []


def turned_over(log: Log) -> Log:
    """A log whose command has the other sign.

    Args:
        log: The log.

    Returns:
        The same, its command turned over.
    """
    return replace(log, command=-log.command)


WAYS: tuple[tuple[Callable[[Log], Log], str, str], ...] = (
    (
        turned_over,
        "the command's sign turned over",
        "is its sign wrong, or that of all readings? Write sign = -1 for it in [columns]",
    ),
    (
        from_degrees,
        "angles taken for degrees",
        'are the readings in degrees? Write unit = "deg" in [columns], or divide them by 57.296',
    ),
)
"""Logs without a mistake, what was done to them, and what is asked where a fit follows them plainly better."""


def _followed(rig: Rig, logs: Sequence[Log]) -> list[float]:
    """Share of each log's motion that a fit removes [1], or that the file's numbers remove where that suffices; none where none can be fitted."""
    if (here := at_own_numbers(rig, logs)) is None:
        return []
    shares = _shares(here)
    if max(shares) >= AS_IT_IS:
        return shares
    nodes = measured_nodes(here.problem, here.theta)
    return _shares(least_squares(here.problem, here.coordinates, here.theta, nodes=nodes, most_steps=STEPS))


def _shares(fit: Fit) -> list[float]:
    """Share of each log's motion that a fit's free run removes [1]."""
    return [explained(run) for run in free_runs(fit.problem, fit.theta, fit.problem.batch, fit.start)]
