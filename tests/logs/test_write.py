"""Log files written: what is written reads back equal, and a failed write leaves the old file."""

import math
import os
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rwjax.errors import LogError, printable
from rwjax.logs.read import read_log
from rwjax.logs.write import write_log
from rwjax.rig.columns_section import Source
from tests.logs.texts import PLATFORM


@given(
    readings=st.lists(st.floats(-1e9, 1e9) | st.just(math.nan), min_size=10, max_size=30).filter(
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
    assert (
        tmp_path / "run.csv"
    ).read_text() == "# layout: rwjax\n# rig: testbed\ntime_s,yaw_counts,yaw_rad_s\n0.0,3,\n0.1,-4,1e-09\n"


@given(
    notes=st.dictionaries(
        st.sampled_from(("run", "why", "rig")),
        st.text(max_size=20)
        | st.sampled_from(["validate", "x\nrole: validate", "x\r# add axis.inertia: 9", "a\u2028b: c"]),
    )
)
@settings(max_examples=30, deadline=None)
def test_a_note_stays_one_note_whatever_it_says(tmp_path_factory, notes: dict[str, str]) -> None:
    path = tmp_path_factory.mktemp("log") / "run.csv"
    write_log(path, {"time_s": 0.1 * np.arange(10), "voltage_V": np.zeros(10), "yaw_rad": np.zeros(10)}, notes)
    run = read_log(path, PLATFORM)
    assert run.notes == {"layout": "rwjax"} | {key: printable(value).strip() for key, value in notes.items()}
    assert not run.validate and run.added == {}


def test_what_was_written_is_read_as_it_is_whatever_other_files_of_the_rig_call_their_columns(tmp_path) -> None:
    path, rig = tmp_path / "run.csv", replace(PLATFORM, sources={"time_s": Source("t"), "voltage_V": Source("u")})
    columns = {"time_s": 0.1 * np.arange(10), "voltage_V": np.ones(10), "yaw_rad": np.zeros(10)}
    write_log(path, columns, {"layout": "bench 3", "Layout": "x", "run": "a"})
    log = read_log(path, rig)
    assert log.command[0] == 1.0 and log.notes == {"layout": "rwjax", "run": "a"}


def test_a_note_that_would_read_back_as_a_role_is_refused(tmp_path) -> None:
    with pytest.raises(
        LogError, match="the note `comment: Train` reads as a role; write `role: train`, or other words"
    ):
        write_log(tmp_path / "run.csv", {"time_s": np.arange(10)}, {"comment": "Train"})
    assert not (tmp_path / "run.csv").exists()


@pytest.mark.parametrize("key", ["a:b", "a\nrole", "", " a", "#", "\x1b"])
def test_a_key_that_would_read_back_as_another_is_refused(tmp_path, key: str) -> None:
    with pytest.raises(ValueError, match="a note's key"):
        write_log(tmp_path / "run.csv", {"time_s": np.arange(3)}, {key: "x"})
    assert not (tmp_path / "run.csv").exists()


@pytest.mark.parametrize("name", ["a,b", "a\nb", "", "yaw_rad ", "#yaw_rad"])
def test_a_column_that_would_read_back_as_another_is_refused(tmp_path, name: str) -> None:
    with pytest.raises(ValueError, match="a column's name"):
        write_log(tmp_path / "run.csv", {"time_s": np.arange(3), name: np.arange(3)})
    assert not (tmp_path / "run.csv").exists()


def test_what_is_not_finite_is_not_written(tmp_path) -> None:
    with pytest.raises(LogError, match="run.csv: not written, since `yaw_rad` is not finite"):
        write_log(tmp_path / "run.csv", {"time_s": np.arange(3), "yaw_rad": np.array([0.0, np.inf, np.nan])})
    assert not (tmp_path / "run.csv").exists()
