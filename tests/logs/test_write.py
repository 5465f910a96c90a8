"""Log files written: what is written reads back equal, and a failed write leaves the old file."""

import math
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.errors import LogError
from rwjax.logs.read import read_log
from rwjax.logs.write import write_log
from tests.logs.texts import PLATFORM


@given(
    readings=st.lists(st.floats(-1e12, 1e12) | st.just(math.nan), min_size=10, max_size=30).filter(
        lambda x: np.isfinite(x).sum() >= 10
    )
)
def test_what_is_written_reads_back_equal(tmp_path_factory, readings):
    path, t = tmp_path_factory.mktemp("log") / "run.csv", np.cumsum(np.full(len(readings), 0.1))
    write_log(
        path,
        {"time_s": t, "voltage_V": np.arange(len(t)), "yaw_rad": np.array(readings)},
        {"role": "validate"},
    )
    run = read_log(path, PLATFORM)
    assert run.validate and np.array_equal(run.time, t)
    kept = ~np.isin(t, run.left_out.get("yaw_rad", []))
    assert np.array_equal(run.outputs["yaw_rad"][kept], np.array(readings)[kept], equal_nan=True)
    assert np.isnan(run.outputs["yaw_rad"][~kept]).all()


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("old")
    with pytest.raises(ValueError):
        write_log(path, {"time_s": np.arange(3), "voltage_V": np.arange(4)})
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["run.csv"]
    with pytest.raises(LogError, match="cannot be written: there is no folder .*none; make it first"):
        write_log(tmp_path / "none" / "run.csv", {"time_s": np.arange(3)})


def test_the_file_is_notes_header_and_rows(tmp_path) -> None:
    columns = {"time_s": np.array([0.0, 0.1]), "yaw_counts": np.array([3, -4]), "yaw_rad_s": np.array([np.nan, 1e-9])}
    write_log(tmp_path / "run.csv", columns, {"rig": "testbed"})
    assert (tmp_path / "run.csv").read_text() == "# rig: testbed\ntime_s,yaw_counts,yaw_rad_s\n0.0,3,\n0.1,-4,1e-09\n"
