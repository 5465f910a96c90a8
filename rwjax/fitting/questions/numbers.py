"""What logs cannot tell of a rig's free numbers, from the sensitivities at the rig file's own: nothing is fitted."""

from collections.abc import Sequence

import numpy as np

from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.questions.own_numbers import at_own_numbers
from rwjax.fitting.uncertainty import Uncertainty, scores, strongly_tied, uncertainty
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

BARELY = 0.3
"""Standard error over a number's size above which the logs barely tell it [1]."""


class NothingTold(str):
    """The note that stands alone where no free number leaves a trace."""


def tells_something(rig: Rig, logs: Sequence[Log]) -> bool:
    """Whether logs tell anything of the rig's free numbers, were the rig file's own right.

    Args:
        rig: The rig with its free numbers.
        logs: The logs that are fitted.

    Returns:
        False where no free number leaves a trace, and true where that cannot be said.
    """
    here = at_own_numbers(rig, logs)
    return here is None or _told(here, uncertainty(here))


def about_numbers(rig: Rig, logs: Sequence[Log]) -> list[str]:
    """What the logs leave open of the rig's free numbers, were the rig file's own right and noise all that is left.

    Args:
        rig: The rig with its free numbers.
        logs: The logs that would be fitted.

    Returns:
        One sentence each; none where the logs tell every free number, and where nothing is free. A `NothingTold` alone where no free
        number leaves a trace.
    """
    if (here := at_own_numbers(rig, logs)) is None:
        return []
    found = uncertainty(here)
    if not _told(here, found):
        remedy = "use runs in which the command changes and the rig moves (`rwjax plan` proposes some)"
        return [NothingTold(f"these logs tell nothing of {', '.join(found.names)}: {remedy}")]
    said = [
        f"{note}: add runs that tell it, or fix it"
        for note in found.notes
        if "bound" not in note and "fix one" not in note
    ]
    said += [note for note in found.notes if "fix one" in note]
    open_ = {name for name, error in found.standard_error.items() if not np.isfinite(error)}
    said += [
        f"{a} and {b} are hardly told apart by these logs (correlation {c:+.3f}): fix one, or add a run that moves the rig otherwise"
        for a, b, c in strongly_tied(found)
    ]
    moves = here.coordinates
    scale = moves.slope(here.theta)
    normal = scores(here).normal + np.diag(here.problem.precision[moves.index] * scale**2)
    error = np.sqrt(np.maximum(np.diag(np.linalg.pinv(normal, hermitian=True)), 0.0)) * np.abs(scale)
    said += [
        f"{name} is told to ±{100.0 * e / s:.2g} % by these logs at best: add runs that move more, or fix it"
        for name, e, s in zip(here.free, error, np.abs(moves.size), strict=True)
        if name not in open_ and e > BARELY * s
    ]
    return said


def _told(here: Fit, found: Uncertainty) -> bool:
    """Whether any free number leaves a trace, or may leave one off the bound on which they all sit."""
    return found.tells_something or bool(np.logical_or(*here.coordinates.on_bound(here.theta)).all())
