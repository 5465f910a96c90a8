"""How far a measured motion follows a simulated one."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.questions.likeness import Run, explained, likeness, motion, names_of
from tests.systems import record

TIME = np.arange(1000) / 64.0
RATE = np.sin(3.0 * TIME)
ANGLE = (1.0 - np.cos(3.0 * TIME)) / 3.0
LOG = record(TIME, RATE, {"yaw_rad": ANGLE, "yaw_rad_s": RATE})


def test_of_an_angle_its_change_within_half_a_second_moves_and_of_a_rate_the_rate() -> None:
    np.testing.assert_allclose(motion(LOG, "yaw_rad", ANGLE), ANGLE[32:] - ANGLE[:-32])
    assert motion(LOG, "yaw_rad_s", RATE) is RATE
    np.testing.assert_allclose(motion(LOG, "yaw_rad", ANGLE + 7.0), motion(LOG, "yaw_rad", ANGLE), atol=1e-12)


@pytest.mark.parametrize("times", [1.0, 0.5, -2.0])
def test_a_multiple_is_alike_in_shape_and_explained_by_its_size(times: float) -> None:
    log = replace(LOG, outputs={name: times * y for name, y in LOG.outputs.items()})
    found = likeness(Run(log, {"yaw_rad": ANGLE, "yaw_rad_s": RATE}), "yaw_rad")
    assert found == pytest.approx((np.sign(times), times, 1.0 - (times - 1.0) ** 2 / times**2))


def test_readings_that_are_missing_do_not_count_and_what_stands_still_is_like_nothing() -> None:
    holes = np.where(np.arange(len(TIME)) % 3 == 0, np.nan, ANGLE)
    log = replace(LOG, outputs={"yaw_rad": holes})
    assert likeness(Run(log, {"yaw_rad": ANGLE}), "yaw_rad") == pytest.approx((1.0, 1.0, 1.0))
    assert likeness(Run(log, {"yaw_rad": np.zeros(len(TIME))}), "yaw_rad") == (0.0, 0.0, 0.0)
    assert likeness(Run(log, {"yaw_rad": np.full(len(TIME), 1e300) * TIME}), "yaw_rad") == (0.0, 0.0, 0.0)


def test_the_share_is_the_mean_over_outputs_and_never_below_minus_one() -> None:
    assert explained(Run(LOG, {"yaw_rad": ANGLE, "yaw_rad_s": 1e6 * RATE})) == pytest.approx(0.0)


def test_several_logs_are_named_by_the_first() -> None:
    logs = [replace(LOG, name=name) for name in ("a.csv", "b.csv", "c.csv")]
    assert [names_of(logs[:n]) for n in (1, 2, 3)] == ["a.csv", "a.csv and b.csv", "a.csv and 2 more"]
