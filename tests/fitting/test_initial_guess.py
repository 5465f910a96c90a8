"""What the first readings say of the initial state."""

import numpy as np

from rwjax.fitting.initial_guess import starts_at_rest
from tests.systems import record

TIME = np.arange(601) * 0.01


def test_an_offset_of_the_current_does_not_set_a_run_in_motion() -> None:
    u = np.where(TIME > 0.6, 3.0, 0.0)
    log = record(TIME, u, {"yaw_rad": np.zeros_like(TIME), "current_A": np.full_like(TIME, 0.02)})
    assert starts_at_rest(log)
    assert not starts_at_rest(record(TIME, u + 0.004, log.outputs))
