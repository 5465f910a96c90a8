"""Logs laid out on uniform time grids."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.plant.from_rig import structure_of
from rwjax.plant.structure import LONGEST_STEP, ServoStructure
from rwjax.simulation.batch import Batch
from rwjax.simulation.layout import EARLIEST, lay_out, share_of_readings
from tests.joints import joint, servo
from tests.systems import platform, record

STRUCTURE = structure_of(platform())


def test_a_count_that_stays_is_one_reading() -> None:
    counts = np.array([1.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0, 4.0])
    assert share_of_readings(counts, 1.0) == pytest.approx([1.0, 1.0, 1.0, 0.25, 0.25, 0.25, 0.25, 1.0])
    assert np.array_equal(share_of_readings(counts, 0.0), np.ones(8))


def test_slots_say_when_a_sample_was_taken() -> None:
    t = np.sort(np.random.default_rng(0).uniform(0.0, 2.0, 150))
    batch = lay_out(STRUCTURE, [record(t, np.zeros_like(t))], [{"yaw_rad": 1.0}])
    window = np.arange(batch.windows)[:, None] * len(batch.step_index)
    time = (window + batch.slot_step[0] + batch.slot_part[0]) * batch.h[0]
    used = batch.slot_sample[0] >= 0
    assert np.array_equal(batch.slot_sample[0][used], np.arange(150))
    assert time[used] == pytest.approx(t - t[0], abs=1e-6 * LONGEST_STEP)


@pytest.mark.parametrize(("needed", "room"), [(1, 4), (4, 4), (5, 8), (9, 16), (17, 32), (65, 80)])
def test_arrays_have_room_for_few_numbers_of_windows(needed: int, room: int) -> None:
    t = LONGEST_STEP * np.arange(32 * (needed - 1) + 2)
    batch = lay_out(STRUCTURE, [record(t, np.zeros_like(t))], [{"yaw_rad": 1.0}])
    assert len(batch.step_index) == 32 and batch.windows_of.max() == needed
    assert batch.windows == room


def test_rates_take_short_steps_and_angles_share_them() -> None:
    t = np.arange(1001) * 0.001
    log = record(t, np.zeros_like(t), {"yaw_rad": np.zeros_like(t)})
    with_rate = record(t, np.zeros_like(t), {"yaw_rad": np.zeros_like(t), "yaw_rad_s": np.zeros_like(t)})
    noise = [{"yaw_rad": 1.0, "yaw_rad_s": 1.0}]
    assert lay_out(STRUCTURE, [log], noise).h == pytest.approx([0.005])
    assert lay_out(STRUCTURE, [with_rate], noise).h == pytest.approx([0.001])
    assert lay_out(STRUCTURE, [log], noise, refine=2).h == pytest.approx([0.0025])


def test_logs_of_one_rig_share_their_programs_though_its_clock_is_not_quite_what_it_says() -> None:
    def batch(dt: float, jitter: float = 0.0) -> Batch:
        t = dt * (np.arange(1501) + jitter * np.random.default_rng(0).uniform(-0.5, 0.5, 1501))
        return lay_out(STRUCTURE, [record(t, np.zeros_like(t))], [{"yaw_rad": 1.0}])

    for dt in (0.01, LONGEST_STEP, 0.5 * LONGEST_STEP, 1 / 60, 1 / 120, 1 / 240, 1 / 256):
        shapes = [[a.shape for a in batch(factor * dt)] for factor in (1.0, 0.992, 1.0001, 1.008)]
        assert shapes == shapes[:1] * 4, dt
    assert len({len(batch(0.00125, jitter).sample_index) for jitter in (0.0, 0.5, 0.9)}) == 1


def test_a_tick_of_a_servo_is_one_step_though_the_log_s_clock_is_a_little_fast() -> None:
    structure = structure_of(servo(joint()))._replace(servo=ServoStructure("error", 0.001, 1.0))
    for dt, steps in ((0.001, 1), (0.0009999, 1), (0.0007, 2)):
        t = dt * np.arange(500)
        log = record(t, np.zeros_like(t), {"yaw_rad_s": np.zeros_like(t)})
        assert lay_out(structure, [log], [{"yaw_rad_s": 1.0}]).h == pytest.approx([0.001 / steps]), dt


def test_missing_readings_weigh_nothing_and_others_their_noise() -> None:
    t = np.arange(50) * 0.01
    log = record(t, np.zeros_like(t), {"yaw_rad": np.where(t == t[7], np.nan, t)})
    batch = lay_out(STRUCTURE, [log], [{"yaw_rad": 0.5}])
    weight = batch.weight[0][..., 0][batch.slot_sample[0] >= 0]
    assert np.array_equal(weight, np.where(np.arange(50) == 7, 0.0, 2.0)) and np.isfinite(batch.reading).all()


def test_a_cut_keeps_the_commands_of_the_second_before() -> None:
    t = np.arange(401) * 0.01
    cut = record(t, t, {"yaw_rad": t}).cut(300, 401)
    batch = lay_out(STRUCTURE, [cut], [{"yaw_rad": 1.0}])
    early = np.flatnonzero(batch.t_command[0] < -1e-9)
    assert batch.t_command[0][early[0]] == pytest.approx(-EARLIEST, abs=0.011)
    assert batch.u_command[0][early] == pytest.approx(3.0 + batch.t_command[0][early])
    assert batch.t0 == pytest.approx([3.0])


def test_late_readings_make_windows_overlap() -> None:
    t = np.arange(200) * 0.01
    late = STRUCTURE.with_effects("sensor.delay")
    batch = lay_out(late, [record(t, np.zeros_like(t))], [{"yaw_rad": 1.0}])
    assert len(batch.overlap_index) * batch.h[0] == pytest.approx(late.longest_encoder_delay, abs=batch.h[0])
    later = batch.slot_step[batch.slot_sample >= 0]
    assert later.max() >= len(batch.step_index)


def test_every_run_finds_its_own_numbers_behind_the_shared_ones() -> None:
    t = np.arange(20) * 0.01
    logs = [record(t, t), replace(record(t, t), added={"axis.inertia": 0.01})]
    batch = lay_out(STRUCTURE, logs, [{"yaw_rad": 1.0}] * 2, per_run=("axis.inertia",))
    p, k = len(STRUCTURE.names), STRUCTURE.names.index("axis.inertia")
    assert batch.theta_index[:, k].tolist() == [p, p + 1]
    assert batch.theta_offset[:, k].tolist() == [0.0, 0.01]


def test_a_gap_that_makes_too_many_steps_is_named() -> None:
    t = np.append(np.arange(10) * 0.001, 1e5)
    with pytest.raises(
        LogError, match=r"test.csv: 1e\+05 s in steps of 0.001 s are too many; the widest gap, 1e\+05 s, follows"
    ):
        lay_out(STRUCTURE, [record(t, t, {"yaw_rad_s": t})], [{"yaw_rad_s": 1.0}])
