"""The worst windows: where the error of the held-out logs arises."""

import numpy as np

from rwjax.diagnosis.gap import HeldOut
from rwjax.diagnosis.worst_windows import Window, worst_windows
from tests.systems import record

TIME = 2.0 + np.arange(1001) * 0.01


def errors(error: np.ndarray) -> HeldOut:
    return HeldOut({"yaw_rad": error**2}, {}, {}, {}, {0: {"yaw_rad": error}})


def test_the_seconds_with_the_most_error_come_first() -> None:
    error = np.zeros(len(TIME))
    error[300:400], error[710:720] = 1.0, 1.0
    found = worst_windows(errors(error), [record(TIME, TIME)], "yaw_rad", 5)
    assert found[0] == Window("test.csv", 5.0, 6.0, 100.0 / 110.0)
    assert found[1] == Window("test.csv", 9.0, 10.0, 10.0 / 110.0)
    assert len(found) == 5 and all(w.share == 0.0 for w in found[2:])


def test_the_last_window_ends_with_its_log() -> None:
    error = np.zeros(len(TIME))
    error[-1] = 1.0
    assert worst_windows(errors(error), [record(TIME, TIME)], "yaw_rad", 5)[0] == Window("test.csv", 12.0, 12.0, 1.0)


def test_no_error_has_no_windows() -> None:
    assert worst_windows(errors(np.zeros(len(TIME))), [record(TIME, TIME)], "yaw_rad", 5) == ()
