"""Questions about the clock of a log: time in tenths or in thousandths, or counted too slowly.

A clock that runs ten times too slowly looks like an inertia that is ten times too large, and no fit tells them apart.
"""

from collections.abc import Callable, Sequence

import numpy as np

from rwjax.fitting.questions.likeness import AS_IT_IS, GIVEN, Question, Run, explained, names_of, plainly_better
from rwjax.logs.log import Log

FACTORS = (0.1, 10.0, 1e-3, 1e3)
"""True time over the time in the log [1]."""
MILLI = 1e-3
"""The same of a time in ms that was read as s [1]."""
LEAST_S, COARSEST_S = 0.3, 1.0
"""Length [s] of the shortest run, and time [s] between samples of the coarsest one, that anybody records of such a rig."""


def about_clock(runs: Sequence[Run], in_time: Callable[[float], Sequence[Run]]) -> dict[Question, list[int]]:
    """Questions about the clock, where the free run in another time is like the readings and that in the log's is not.

    Args:
        runs: Logs with their free runs.
        in_time: The same logs with their free runs in the log's time multiplied by a factor.

    Returns:
        The questions, each with the numbers of the logs that it is about.
    """
    shares = {k: share for k, run in enumerate(runs) if (share := explained(run)) < AS_IT_IS}
    found: dict[Question, list[int]] = {}
    for factor in FACTORS:
        asked = {k: share for k, share in shares.items() if _plausible(runs[k].log, factor)}
        other = in_time(factor) if asked else []
        if not any(plainly_better(share, explained(other[k])) for k, share in asked.items()):
            continue
        # beside a log whose time is plainly another one, so are those that it explains better
        slow = [k for k, run in enumerate(runs) if explained(other[k]) > explained(run) and _plausible(run.log, factor)]
        shares = {k: share for k, share in shares.items() if k not in slow}
        found[_question(names_of([runs[k].log for k in slow]), factor)] = slow
    return found


def _plausible(log: Log, factor: float) -> bool:
    """Whether a log in another time is one that somebody records: numbers of a first rig file are guesses, and may ask for any time."""
    length, step = np.ptp(log.time), np.median(np.diff(log.time))
    return bool(length * factor >= LEAST_S and step * factor <= COARSEST_S)


def _question(names: str, factor: float) -> Question:
    if factor < 1.0:
        slow, key = 1.0 / factor, 'unit = "ms"' if factor == MILLI else f"scale = {factor:g}"
        return Question(
            f"{names}: {slow:g} times slower than {GIVEN}: is the time in units of {factor:g} s? Divide `time_s` by {slow:g}, or write {key} "
            "for it in [columns]"
        )
    key = "correct its unit in [columns]" if factor == 1.0 / MILLI else f"write scale = {factor:g} for it in [columns]"
    return Question(
        f"{names}: {factor:g} times faster than {GIVEN}: is a second of the clock {factor:g} s? Multiply `time_s` by {factor:g}, or {key}"
    )
