"""Long logs with fewer samples."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import fit, simulate
from rwjax.logs.thin import thinned
from tests.systems import platform, record

TIME = 0.001 * np.arange(20_000)
VOLTS = 2.0 * np.sign(np.sin(2.0 * np.pi * TIME / 1.7)) + np.sin(2.0 * np.pi * 0.6 * TIME)


def test_short_or_coarse_logs_stay_as_they_are() -> None:
    log = record(TIME, VOLTS)
    assert thinned([log], 20_000, 0.01) == ((log,), "")
    assert thinned([log], 100, 0.0019) == ((log,), "")  # two steps would be too coarse


@pytest.mark.parametrize(("samples", "every"), [(10_000, 2), (6000, 4), (100, 10)])
def test_together_they_have_no_more_samples_than_wanted_unless_that_is_too_coarse(samples: int, every: int) -> None:
    log = record(TIME, VOLTS, {"yaw_rad": TIME**2})
    (one, other), said = thinned([log, replace(log, supply=VOLTS + 12.0)], 2 * samples, 0.01)
    assert np.array_equal(one.time, TIME[::every]) and np.array_equal(one.outputs["yaw_rad"], TIME[::every] ** 2)
    assert one.command == pytest.approx(VOLTS.reshape(-1, every).mean(axis=1), abs=1e-9)
    assert other.supply is not None and other.supply == pytest.approx(one.command + 12.0)
    assert said.startswith(f"the logs have 40000 samples, of which every {every}th was taken ({40000 // every})")


def test_a_command_between_irregular_samples_is_weighed_by_how_long_it_is_held() -> None:
    log = record(np.array([0.0, 1.0, 4.0, 5.0, 6.0]), np.array([1.0, 5.0, 2.0, 4.0, 7.0]))
    (found,), _ = thinned([log], 3, 10.0)
    assert found.time.tolist() == [0.0, 4.0, 6.0] and found.command == pytest.approx([4.0, 3.0, 7.0])


def test_both_axes_are_thinned() -> None:
    (found,), _ = thinned([record(TIME, np.stack([VOLTS, -VOLTS], axis=1))], 10_000, 0.01)
    assert found.command.shape == (10_000, 2) and np.array_equal(found.command[:, 0], -found.command[:, 1])


def test_estimates_from_thinned_logs_are_those_of_the_whole_ones_within_their_errors() -> None:
    rig, rng = platform("viscous = 0.02\ncoulomb = 0.05"), np.random.default_rng(1)
    angle = np.asarray(simulate(rig, TIME, VOLTS)["yaw_rad"]) + rng.normal(0.0, 1e-3, len(TIME))
    log = record(TIME, VOLTS, {"yaw_rad": angle})
    (less,), _ = thinned([log], 2000, 0.01)
    whole, thin = (fit(rig, [one]) for one in (log, less))
    error = [one.rig.standard_error["axis.inertia"] for one in (whole, thin)]
    assert 2.0 < error[1] / error[0] < 5.0  # the root of ten
    assert abs(thin.rig.values["axis.inertia"] - 0.1) < 4.0 * error[1]
