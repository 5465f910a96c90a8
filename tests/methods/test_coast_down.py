"""Coast-downs: the filter, and which stretches are taken."""

import numpy as np
import pytest

from rwjax.methods.coast_down import coast_downs, filtered_speed
from tests.systems import platform, record, run


def test_the_filter_is_exact_for_a_straight_angle() -> None:
    t = np.arange(400) * 0.01
    assert filtered_speed(t, 1.0 + 3.0 * t)[200:] == pytest.approx(3.0, rel=1e-12)


def test_only_stretches_without_input_are_taken() -> None:
    rig = platform()
    t = np.arange(1501) * 0.01
    u = np.where((t > 0.5) & (t < 3.0), 1.0, 0.0)
    log = record(t, u, {"yaw_rad": run(rig, record(t, u), {})["yaw_rad"]})
    (stretch,) = coast_downs(rig, log)
    assert np.all(stretch.speed > 0.0) and np.all(np.diff(stretch.speed) < 0.0)
    assert stretch.time[-1] < 12.0
