"""Questions about a servo's log by itself: a position that follows neither its goal nor its logged speed, but in degrees or with the other sign.

A position loop that works brings the position near its goal, and a position changes by the integral of its speed. No model is asked.
"""

from collections.abc import Callable, Collection, Sequence

import numpy as np

from rwjax.fitting.questions.likeness import Question, names_of
from rwjax.fitting.questions.rates import DEGREES, FAR, times_the_way
from rwjax.kinds import GOAL
from rwjax.logs.log import Log

POSITION, SPEED = "yaw_rad", "yaw_rad_s"
"""What a goal is about, and its rate."""
TIMES = (DEGREES, 1.0 / DEGREES, -1.0)
"""Position as a multiple of what it should be, by a mistake [1]."""
NEAR, NEARER = 0.5, 0.5
"""Distance from the goal, as a share of the goal's own motion and of the distance as logged, below which a position follows it [1]."""
RESTED = 0.5
"""Time after which a position has come to a goal that stays the same [s]."""


def about_servos(logs: Sequence[Log], unsigned: Collection[str] = ()) -> list[Question]:
    """Questions about the unit or the sign of positions that contradict their goal or their logged speed.

    Nothing is asked of samples without torque, of a goal that stays the same, and of a servo that hardly follows: of a position
    that does not come near its goal in degrees or with the other sign either. A servo that is driven faster than it can follow goes
    against its goal, so that the sign is asked about by a goal that rests, or by the speed.

    Args:
        logs: The logs; those without a goal or without positions are passed over.
        unsigned: Outputs of which the logs hold the size alone.

    Returns:
        The questions, one sentence each.
    """
    odd: dict[float, list[Log]] = {}
    against: dict[float, set[str]] = {}
    for log in logs:
        if log.input != GOAL or POSITION not in log.outputs:
            continue
        found = {
            GOAL: _times_the_goal(log),
            SPEED: times_the_way(log, POSITION, _mistake) if SPEED not in unsigned else None,
        }
        for times in {given for given in found.values() if given is not None}:
            odd.setdefault(times, []).append(log)
            against.setdefault(times, set()).update(name for name, given in found.items() if given == times)
    return [_question(names_of(odd[times]), times, sorted(against[times])) for times in TIMES if times in odd]


def _question(names: str, times: float, against: Sequence[str]) -> Question:
    """The question about a position that is so many times what others say."""
    others, are, say = " and ".join(against), *(("is", "says") if len(against) == 1 else ("are", "say"))
    if times < 0.0:
        return Question(
            f"{names}: {POSITION} goes against what {others} {say}: is its sign wrong, or that of {others}? `sign` in [columns] turns it"
        )
    large, small = (POSITION, others) if times > 1.0 else (others, POSITION)
    in_, already = ("is", are) if times > 1.0 else (are, "is")
    return Question(
        f"{names}: {POSITION} moves about {times:.3g} times as far as {others} {say}: {in_} {large} in degrees, or {already} {small} in "
        "radians already? Give the right `unit` in [columns]"
    )


def _times_the_goal(log: Log) -> float | None:
    """How many times its goal a position is by a mistake, None where it may be right."""
    used = np.isfinite(log.outputs[POSITION]) & (True if log.enabled is None else log.enabled.astype(bool))
    changed = np.append(True, np.diff(log.command) != 0.0)
    since = log.time - log.time[np.maximum.accumulate(np.where(changed, np.arange(len(changed)), 0))]

    def follows(times: float) -> bool:
        taken = used & (since >= RESTED) if times < 0.0 else used
        position, goal = log.outputs[POSITION][taken], log.command[taken]

        def away(many: float) -> float:
            return float(np.sqrt(np.mean((position / many - goal) ** 2)))

        return bool(taken.any()) and away(times) < min(NEAR * float(np.std(goal)), NEARER * away(1.0))

    return _first(follows)


def _mistake(times: float) -> float | None:
    """The mistake that a factor between a position's changes and its logged speed tells."""
    return _first(lambda known: 1.0 / FAR < times / known < FAR)


def _first(holds: Callable[[float], bool]) -> float | None:
    """The first mistake for which something holds."""
    return next((times for times in TIMES if holds(times)), None)
