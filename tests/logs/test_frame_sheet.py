"""Data frames as tables."""

import numpy as np
import polars as pl
import pytest

from rwjax.errors import LogError
from rwjax.logs.frame_sheet import frame_sheet
from rwjax.logs.log import Log
from tests.logs.forms import MEASURED, RIG, SI


def test_a_frame_of_polars_is_a_table_of_its_columns() -> None:
    sheet = frame_sheet(pl.DataFrame(MEASURED | {"word": ["x"] * 50}), "frame")
    assert [*sheet.names] == [*MEASURED, "word"]
    assert np.array_equal(sheet.numbers(["angle"])[0], MEASURED["angle"])
    assert sheet.where(4) == "frame: row 5"


@pytest.mark.parametrize("indexed", [False, True])
def test_a_frame_of_pandas_may_have_its_time_as_index(indexed: bool) -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(MEASURED)
    log = Log.from_frame(RIG, frame.set_index("ms") if indexed else frame)
    kept = Log.from_frame(RIG, frame.set_index("ms", drop=False))
    assert np.array_equal(kept.time, log.time)
    assert np.array_equal(log.time, SI["time_s"]) and np.array_equal(log.outputs["yaw_rad"], SI["yaw_rad"])


def test_missing_values_are_missing_readings() -> None:
    angle = [None if k == 7 else value for k, value in enumerate(MEASURED["angle"].tolist())]
    log = Log.from_frame(RIG, pl.DataFrame(MEASURED | {"angle": angle}), name="with a hole")
    assert np.flatnonzero(np.isnan(log.outputs["yaw_rad"])).tolist() == [7] and log.name == "with a hole"


def test_what_is_no_frame_is_refused() -> None:
    with pytest.raises(LogError, match="frame: a list is no data frame; give one of pandas or polars"):
        frame_sheet([1, 2], "frame")
