"""Questions about readings that lost their sign: a speed by the pulses of one hall sensor, a current by its size.

Such readings are right, and no simulation follows them: they go up where it goes down. So they are compared with the size of
what is simulated, here and in every other question.
"""

from collections.abc import Sequence

import numpy as np

from rwjax.fitting.questions.likeness import Question, Run
from rwjax.kinds import is_angle

SIDE = 0.1
"""Share of the simulated motion's square that has to lie on each side of 0 [1]: by less, a run hardly reverses."""
FOLLOWS = 0.7
"""Correlation with the simulated size on each side of 0 [1]; what keeps its sign about an offset has a negative one on one side."""
EVEN = 1.6
"""Ratio of the readings to the simulated size on one side over that on the other, from which they tell the two apart [1]."""


def about_lost_signs(runs: Sequence[Run]) -> dict[str, Question]:
    """Questions about outputs that are never negative, and that follow the size of a simulation that is.

    Args:
        runs: Logs with their free runs.

    Returns:
        The questions by output, one sentence each; none of an output that is negative in any log, or an angle.
    """
    found = {}
    for name in dict.fromkeys(name for run in runs for name in run.log.outputs):
        held = [run for run in runs if np.isfinite(run.log.outputs.get(name, np.nan)).any()]
        if is_angle(name) or any(np.nanmin(run.log.outputs[name]) < 0.0 for run in held):
            continue
        reversing = [run for run in held if _reverses(run.simulated[name][np.isfinite(run.log.outputs[name])])]
        if reversing and all(_is_size_of(run.log.outputs[name], run.simulated[name]) for run in reversing):
            found[name] = Question(
                f"{name} never goes below 0, and follows the command of both signs by its size: is it a size without sign? "
                f"Give {name} = {{ …, unsigned = true }} in [columns]"
            )
    return found


def _reverses(simulated: np.ndarray) -> bool:
    """Whether a simulated reading lies on both sides of 0 for much of its square."""
    power = simulated**2
    return (
        bool(np.isfinite(power).all())
        and SIDE < float(power[simulated < 0.0].sum() / (power.sum() or 1.0)) < 1.0 - SIDE
    )


def _is_size_of(y: np.ndarray, simulated: np.ndarray) -> bool:
    """Whether readings follow the size of the simulated ones, as well below 0 as above, and nowhere their sign."""
    seen = np.isfinite(y)
    y, simulated = y[seen], simulated[seen]
    size = np.abs(simulated)
    sides = [simulated < 0.0, simulated > 0.0]
    below, above = (float(y[side] @ size[side] / (size[side] @ size[side])) for side in sides)
    even = 1.0 / EVEN < below / (above or np.inf) < EVEN
    return even and all(_correlation(y[side], size[side]) > FOLLOWS for side in sides)


def _correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Correlation of two signals about their means [1], 0 where one of them is constant."""
    a, b = a - a.mean(), b - b.mean()
    return float(a @ b) / np.sqrt(float(a @ a) * float(b @ b) or 1.0)
