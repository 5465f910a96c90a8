"""A simulated run as users see it."""

import numpy as np
import pytest

from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of
from rwjax.simulation.trajectory import Trajectory, trajectory_of
from tests.systems import platform, record

TIME = np.array([0.5, 1.0, 2.0])
RUN = Trajectory("pendulum", TIME, {"yaw_rad": np.array([0.0, 1.0, -2.0]), "yaw_rad_s": np.array([3.0, np.nan, 4.0])})


def test_it_is_a_mapping_of_outputs() -> None:
    assert [*RUN] == ["yaw_rad", "yaw_rad_s"] and len(RUN) == 2 and "current_A" not in RUN
    assert RUN["yaw_rad"][2] == -2.0 and RUN.duration == 1.5
    assert [*RUN.columns] == ["time_s", "yaw_rad", "yaw_rad_s"] and RUN.columns["time_s"] is TIME
    with pytest.raises(KeyError, match="no output `current_A`; this run has yaw_rad, yaw_rad_s"):
        RUN["current_A"]


def test_it_prints_its_name_its_length_and_ranges_with_units() -> None:
    assert str(RUN) == "pendulum: 1.5 s, 3 samples\n  yaw_rad    -2 to 1 rad\n  yaw_rad_s  3 to 4 rad/s"


def test_runs_are_equal_where_every_value_is() -> None:
    same = Trajectory("pendulum", TIME.copy(), {name: values.copy() for name, values in RUN.items()})
    assert same == RUN
    assert RUN != Trajectory("pendulum", TIME, RUN.outputs | {"yaw_rad": np.array([0.0, 1.0, -2.1])})


def test_readings_come_in_the_order_of_the_samples() -> None:
    t = np.arange(81) * 0.01  # several windows
    structure, log = structure_of(platform()), record(t, np.zeros_like(t))
    batch = pose(structure, (log,), {"yaw_rad": 1.0}).batch
    by_slot = np.where(batch.slot_sample >= 0, batch.slot_sample, -7.0)[0][..., None] * [1.0, 10.0]
    found = trajectory_of(structure, batch, log, by_slot)
    assert batch.windows > 1 and found.name == log.name
    assert np.array_equal(found["yaw_rad"], np.arange(81.0)) and np.array_equal(
        found["yaw_rad_s"], 10.0 * np.arange(81)
    )
