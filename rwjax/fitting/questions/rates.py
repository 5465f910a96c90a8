"""Questions about a logged rate that contradicts the change of its angle: in degrees or turns, per minute or millisecond, or with the other sign.

An angle changes by the integral of its rate. No model is asked.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from rwjax.fitting.questions.likeness import ALIKE, Question, Run, likeness, names_of
from rwjax.kinds import GOAL, is_angle
from rwjax.logs.log import Log

DEGREES, TURN, PER_MINUTE = 180.0 / np.pi, 2.0 * np.pi, np.pi / 30.0
"""Degrees in a radian; radians in a turn; what one turn per minute is in rad/s [1, rad, rad/s]."""
FAR, NEAR, NEARLY = 1.6, 1.2, 1.03
"""Factors by which an angle may differ besides from what its rate says in another unit [1]: where no other mistake is near, of an angle in turns, which is
near turns per minute, and of these, which are nearly the tenth of a clock that goes ten times too fast."""
MISTAKES = {
    DEGREES: (FAR, "is {angle} in degrees, or is {rate} in rad/s already?"),
    1.0 / DEGREES: (FAR, "is {rate} in degrees per second, or is {angle} in radians already?"),
    PER_MINUTE: (NEARLY, "is {rate} in turns per minute?"),
    1.0 / TURN: (NEAR, "is {angle} in turns?"),
    TURN: (FAR, "is {rate} in turns per second?"),
    1e-3: (FAR, "is time_s in milliseconds?"),
    1e-6: (FAR, "is time_s in microseconds?"),
}
"""Such a factor, and what is asked, by how many times as far as its rate says an angle moves."""


def about_rates(logs: Sequence[Log], unsigned: Collection[str] = ()) -> list[Question]:
    """Questions about rates that contradict their angle.

    Servos, whose goal tells more, have questions of their own (`servo.py`). Nothing is asked of a rate whose sign was lost.

    Args:
        logs: The logs; those with a goal, and those without an angle and its rate, are passed over.
        unsigned: Outputs of which the logs hold the size alone.

    Returns:
        The questions, one sentence each.
    """
    odd: dict[tuple[str, float], list[Log]] = {}
    for log in logs:
        if log.input == GOAL:
            continue
        for angle in filter(is_angle, log.outputs):
            if not {angle, f"{angle}_s"} & {*unsigned} and (times := times_the_way(log, angle, _mistake)) is not None:
                odd.setdefault((angle, times), []).append(log)
    return [_question(names_of(those), angle, times) for (angle, times), those in odd.items()]


def times_the_way(log: Log, angle: str, mistake: Callable[[float], float | None]) -> float | None:
    """How many times the integral of its rate the changes of an angle are by a mistake.

    Args:
        log: A log.
        angle: Name of one of its outputs; the rate is called as the angle, followed by `_s`.
        mistake: Which mistake a factor tells, None for none.

    Returns:
        The factor of the mistake [1]; None where the rate may be right, is not there, or may be a size without its sign.
    """
    rate = log.outputs.get(f"{angle}_s", np.full(1, np.nan))
    seen = np.isfinite(rate)
    if not seen.any():
        return None
    speed = np.interp(log.time, log.time[seen], rate[seen])
    way = np.append(0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(log.time)))
    found = likeness(Run(replace(log, outputs={angle: log.outputs[angle]}), {angle: way}), angle)
    if abs(found.correlation) < ALIKE:
        return None
    if found.times < 0.0:
        return -1.0 if np.min(rate[seen]) < 0.0 else None  # else it may be the size alone
    return mistake(found.times)


def _mistake(times: float) -> float | None:
    """The mistake that a factor tells."""
    return next((known for known, (off_by, _) in MISTAKES.items() if 1.0 / off_by < times / known < off_by), None)


def _question(names: str, angle: str, times: float) -> Question:
    """The question about an angle that moves so many times as far as its rate says."""
    rate = f"{angle}_s"
    if times < 0.0:
        return Question(
            f"{names}: {angle} goes against what {rate} says: is its sign wrong, or that of {rate}? `sign` in [columns] turns it"
        )
    asked = MISTAKES[times][1].format(angle=angle, rate=rate)
    return Question(
        f"{names}: {angle} moves about {times:.3g} times as far as {rate} says: {asked} Give the right `unit` in [columns]"
    )
