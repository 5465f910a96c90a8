"""The worst windows: where the error of the held-out logs arises."""

import numpy as np

from rwjax.diagnosis.gap import HeldOut
from rwjax.diagnosis.localise.where import Missing
from rwjax.diagnosis.worst_windows import Window, worst_windows
from tests.systems import record

TIME = 2.0 + np.arange(1001) * 0.01


def errors(error: np.ndarray) -> HeldOut:
    return HeldOut({"yaw_rad": error**2}, {}, {}, {}, {0: {"yaw_rad": error}})


def test_the_seconds_with_the_most_error_come_first() -> None:
    error = np.zeros(len(TIME))
    error[300:400], error[710:720] = 1.0, 1.0
    found = worst_windows((), errors(error), [record(TIME, TIME)], "yaw_rad", 5)
    assert found[0] == Window("test.csv", 5.0, 6.0, 100.0 / 110.0)
    assert found[1] == Window("test.csv", 9.0, 10.0, 10.0 / 110.0)
    assert len(found) == 2  # nothing arises in the others


def test_the_last_window_ends_with_its_log() -> None:
    error = np.zeros(len(TIME))
    error[-1] = 1.0
    assert worst_windows((), errors(error), [record(TIME, TIME)], "yaw_rad", 5)[0] == Window(
        "test.csv", 12.0, 12.0, 1.0
    )


def test_a_missing_torque_counts_where_it_acts_and_not_where_the_run_it_led_astray_is_off() -> None:
    torque, deviation = np.zeros(len(TIME)), np.full(len(TIME), 0.1)
    torque[420:480] = 2.0
    own = np.random.default_rng(0).normal(0.0, 0.1, (len(TIME), 8))
    missing = Missing(0, torque, deviation, {}, own, np.zeros((len(TIME), 9), bool), np.ones((len(TIME), 9)))
    astray = np.where(TIME > 6.5, 1.0, 0.0)
    found = worst_windows((missing,), errors(astray), [record(TIME, TIME)], "yaw_rad", 3)
    assert found[0].begin == 6.0 and found[0].end == 7.0 and found[0].share > 0.98


def test_no_error_has_no_windows() -> None:
    assert worst_windows((), errors(np.zeros(len(TIME))), [record(TIME, TIME)], "yaw_rad", 5) == ()
