"""Long logs with fewer samples."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import fit, simulate
from rwjax.logs.thin import some_of, thinned
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
    assert said.startswith(
        f"the logs have 40000 samples, of which {40000 // every} were taken, one of every {every} of the finest"
    )


def test_a_command_between_irregular_samples_is_weighed_by_how_long_it_is_held() -> None:
    time, command = np.cumsum(np.tile([1.0, 3.0], 20)), np.tile([1.0, 5.0], 20)
    (found,), _ = thinned([record(time, command)], 20, 10.0)
    assert np.array_equal(found.time, time[::2]) and found.command[:-1] == pytest.approx((3.0 * 1.0 + 1.0 * 5.0) / 4.0)


def test_a_sensor_that_is_read_now_and_then_keeps_every_nth_of_its_readings() -> None:
    seldom = np.where(np.arange(len(TIME)) % 10 == 3, TIME, np.nan)
    (found,), _ = thinned([record(TIME, VOLTS, {"yaw_rad": seldom, "yaw_rad_s": TIME})], 4000, 0.01)
    assert np.isfinite(found.outputs["yaw_rad"]).sum() == 400 and found.time[0] == TIME[0]
    read = np.isfinite(found.outputs["yaw_rad"])
    assert np.array_equal(found.outputs["yaw_rad"][read], found.time[read])


def test_a_coarse_log_beside_a_fine_one_stays_and_no_log_is_none() -> None:
    coarse = record(TIME[::20], VOLTS[::20])
    found, said = thinned([record(TIME, VOLTS), coarse], 5000, 0.01)
    assert len(found[0].time) == 4000 and found[1] is coarse and "nothing faster than 0.04 s" in said
    assert thinned([], 10, 0.01) == ((), "")


def test_both_axes_are_thinned() -> None:
    (found,), _ = thinned([record(TIME, np.stack([VOLTS, -VOLTS], axis=1))], 10_000, 0.01)
    assert found.command.shape == (10_000, 2) and np.array_equal(found.command[:, 0], -found.command[:, 1])


@pytest.mark.slow
def test_estimates_from_thinned_logs_are_those_of_the_whole_ones_within_their_errors() -> None:
    rig, rng = platform("viscous = 0.02\ncoulomb = 0.05"), np.random.default_rng(1)
    angle = np.asarray(simulate(rig, TIME, VOLTS)["yaw_rad"]) + rng.normal(0.0, 1e-3, len(TIME))
    log = record(TIME, VOLTS, {"yaw_rad": angle})
    (less,), _ = thinned([log], 2000, 0.01)
    whole, thin = (fit(rig, [one]) for one in (log, less))
    error = [one.rig.standard_error["axis.inertia"] for one in (whole, thin)]
    assert 2.0 < error[1] / error[0] < 5.0  # the root of ten
    assert abs(thin.rig.values["axis.inertia"] - 0.1) < 4.0 * error[1]


def test_of_many_logs_some_stand_for_all_evenly_over_both_roles() -> None:
    log = record(TIME[:1000], VOLTS[:1000])
    logs = [replace(log, name=f"{k}.csv", validate=k % 5 == 0) for k in range(100)]
    assert some_of(logs, 100_000, 3) == (tuple(logs), "")
    found, said = some_of(logs, 25_000, 3)
    numbers = [int(one.name.split(".")[0]) for one in found]
    assert len(found) == 25 and sum(one.validate for one in found) == 5
    assert numbers == sorted(numbers) and (numbers[0], numbers[-1]) == (0, 99) and max(np.diff(numbers)) <= 8
    assert said.startswith("of 100 logs 25 were taken") and said.endswith("about 2 times as large")
    assert len(some_of(logs, 1, 3)[0]) == 6 and some_of(logs[:2], 1, 3)[1] == ""
