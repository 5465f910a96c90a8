"""The thesis's closed-loop runs fitted from their goal."""

import numpy as np
import pytest

from experiments.thesis.closed_loop import COUNT, FREE, fitted, logs_of, rig_of
from experiments.thesis.square_waves import SOFT
from rwjax import simulate

HEIGHTS = (20.0,)


def test_the_rig_s_own_loop_follows_the_goal_as_the_one_that_made_the_runs() -> None:
    """Of a loop that reads the angle itself, from rest: within half a count, by which the log is rounded."""
    (log,) = logs_of(SOFT, HEIGHTS, counts=0)
    missed = np.asarray(simulate(rig_of(SOFT), log.time, {"goal_rad": log.command})["yaw_rad"]) - log.outputs["yaw_rad"]
    assert np.max(np.abs(missed)) < 0.51 * COUNT and np.ptp(log.outputs["yaw_rad"]) > 50.0 * COUNT


@pytest.mark.slow
def test_from_the_goal_the_numbers_come_back_though_the_log_lacks_four_of_five_ticks() -> None:
    logs = logs_of(SOFT, HEIGHTS, every=5)
    truth = np.array([rig_of(SOFT).values[name] for name in FREE])
    by_goal, by_error = (fitted(SOFT, logs, goal) for goal in (True, False))
    assert by_goal.values[:2] == pytest.approx(truth[:2], rel=0.05)
    assert by_goal.rms < COUNT < by_error.rms  # the error of every fifth tick is not what the loop gave
