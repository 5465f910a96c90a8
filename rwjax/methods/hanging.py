"""Whether a joint's link hangs: the logs tell it where nobody has given a mass and a length."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from rwjax.errors import InputError
from rwjax.fitting.questions.after_a_fit import WAYS
from rwjax.logs.log import Log
from rwjax.methods.first_estimates import WEIGHT, WEIGHT_ANGLE, told
from rwjax.methods.known import Known
from rwjax.methods.regression import weak_form
from rwjax.rig.model import GUESS, Rig

SURELY = 50.0
"""Standard errors of a weight in a regression from which a link is said to hang [1]: of simulated joints links of 1 % of the motor's torque had 130 and
more, those without a weight 3 at most. A spring, which pulls back likewise, had 13 and more."""
INERTIA = "axis.inertia"


class Hanging(NamedTuple):
    """What a regression says of a weight.

    Attributes:
        numbers: The weight and its angle by their names [SI], to be estimated; none where it finds none.
        logs: The logs that tell it: as they are, or without a mistake.
        notes: What is to be said of it, a sentence each.
    """

    numbers: dict[str, Known]
    logs: Sequence[Log]
    notes: tuple[str, ...] = ()


def hanging(rig_of: Callable[[dict[str, Known]], Rig], logs: Sequence[Log]) -> Hanging:
    """A weight that the logs tell by themselves, or would tell without a mistake in the command's sign or the angle's unit.

    A weight pulls with the sine of the angle. It is believed where the inertia is told beside it; where a mistake hides it, of a link that hangs down
    at angle 0 alone: an arm that is led by hand while its controller carries it shows a negative one with the command turned over.

    Args:
        rig_of: The first rig file with further numbers.
        logs: Its logs.

    Returns:
        The weight, the logs that tell it, and notes.
    """
    numbers = {
        WEIGHT: Known(0.1, f"{GUESS}: m g l, or --mass and --length", free=True),
        WEIGHT_ANGLE: Known(0.0, "0 where the link hangs down at angle 0"),
    }
    rig = rig_of(numbers)
    if _weight(rig, logs):
        note = (
            f"{WEIGHT}: the logs tell a torque that pulls back with the angle, as a weight does; where nothing hangs, take [axis.gravity] out, "
            "since a spring does likewise"
        )
        return Hanging(numbers, logs, (note,))
    for without, what, asks in WAYS:
        mended = [without(log) for log in logs]
        if all(a is not b for a, b in zip(mended, logs, strict=True)) and _weight(rig, mended) > 0.0:
            note = f"with {what} the logs tell a weight, and as they are none: {asks}. The numbers are those with that done"
            return Hanging(numbers, mended, (note,))
    return Hanging({}, logs)


def _weight(rig: Rig, logs: Sequence[Log]) -> float:
    """The weight by a regression [N m]; 0 where it is not told for sure, or the inertia is not told beside it."""
    try:
        found = weak_form(rig, logs).rig
    except (InputError, ValueError):  # a regression that runs off tells nothing
        return 0.0
    value, error = found.values[WEIGHT], found.standard_error.get(WEIGHT, 0.0)
    surely = abs(value) > SURELY * error > 0.0 and (INERTIA not in rig.free or told(found, INERTIA))
    return value if surely else 0.0
