"""Parts of a batch of logs."""

import numpy as np

from rwjax.plant.from_rig import structure_of
from rwjax.simulation.batch import WITHOUT_LOG_AXIS, by_sample
from rwjax.simulation.layout import lay_out
from tests.systems import platform, record

T = np.arange(201) * 0.01
STRUCTURE = structure_of(platform())
LOGS = [record(t, np.full_like(t, k), {"yaw_rad": 0.1 * k + t}) for k, t in enumerate((T, T[:90], T[:150]))]
BATCH = lay_out(STRUCTURE, LOGS, [{"yaw_rad": 0.5}] * 3)


def test_one_log_is_taken_out_with_all_that_belongs_to_it() -> None:
    alone = BATCH.of(1)
    for name, value in alone._asdict().items():
        whole = getattr(BATCH, name)
        assert np.array_equal(value, whole if name in WITHOUT_LOG_AXIS else whole[1:2]), name


def test_inputs_of_some_logs_hold_no_readings() -> None:
    inputs = BATCH.inputs_of(np.array([2, 2, 0]))
    assert np.array_equal(inputs.u_command, BATCH.u_command[[2, 2, 0]])
    assert np.array_equal(inputs.slot_step, BATCH.slot_step[[2, 2, 0]])
    assert inputs.reading.shape == inputs.weight.shape == (3,)


def test_the_beginning_of_every_log_is_its_first_windows() -> None:
    early = BATCH.until(0.5)
    seen = early.slot_sample[early.slot_sample >= 0]
    assert early.windows < BATCH.windows and T[seen.max()] >= 0.5
    assert np.array_equal(early.reading, BATCH.reading[:, : early.windows])
    assert early.held.shape[1] == BATCH.held.shape[1] - (BATCH.windows - early.windows) * len(BATCH.step_index)


def test_windows_and_readings_are_counted() -> None:
    per_window = len(BATCH.step_index) * BATCH.h
    assert np.array_equal(BATCH.windows_of, np.floor([log.time[-1] for log in LOGS] / per_window).astype(int) + 1)
    assert BATCH.readings == 201 + 90 + 150


def test_values_by_slot_come_back_by_sample() -> None:
    for k, log in enumerate(LOGS):
        assert np.array_equal(by_sample(BATCH, k, BATCH.reading[k], len(log.time))[:, 0], log.outputs["yaw_rad"])
