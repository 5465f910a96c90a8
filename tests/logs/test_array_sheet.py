"""Arrays as tables: what becomes a column, and how a wrong value is pointed at."""

import re
from typing import Any

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.logs.array_sheet import ArraySheet, array_sheet

TEN = np.arange(10.0)


def test_rows_of_numbers_are_found_wherever_they_lie() -> None:
    nested = {
        "a": TEN,
        "s": {"b": TEN[:, None], "deep": {"c": TEN}},
        "Ts": 0.1,
        "xy": np.stack([TEN, 2.0 * TEN], axis=1),
    }
    sheet = array_sheet("run", nested)
    assert {*sheet.names} == {"a", "s.b", "b", "s.deep.c", "c", "xy_1", "xy_2"}
    a, b, c, y = sheet.numbers(["a", "b", "c", "xy_2"])
    assert np.array_equal(a, TEN) and np.array_equal(b, TEN) and np.array_equal(c, TEN) and np.array_equal(y, 2.0 * TEN)


def test_a_name_of_two_structures_needs_the_structure() -> None:
    assert {*array_sheet("run", {"x": {"a": TEN}, "y": {"a": TEN}}).names} == {"x.a", "y.a"}


def test_dates_are_seconds_from_the_first_and_nothing_is_missing() -> None:
    dates = np.datetime64("2026-11-23T18:00:00") + np.arange(10) * np.timedelta64(10, "ms")
    masked = np.ma.masked_greater(np.arange(10), 8)
    table = ArraySheet("run", {}, ["t", "m", "o"], {"t": dates, "m": masked, "o": [None, "", "1.5", *range(7)]})
    t, m, o = table.numbers(["t", "m", "o"], ["t"])
    assert t == pytest.approx(np.arange(10) / 100.0, abs=1e-12)
    assert np.isnan(m[9]) and m[8] == 8.0 and np.isnan(o[:2]).all() and o[2] == 1.5


@pytest.mark.parametrize(
    ("column", "message"),
    [
        (["x", *range(9)], "run: sample 1: `b` is 'x'; it has to be a number, or missing"),
        ([*range(9), [1]], "run: sample 10: `b` is a list; it has to be a number"),
        (np.arange(9), "run: `b` has 9 values, and `a` 10; give equally many"),
        (np.zeros((10, 3)), "run: `b` has the shape (10, 3); a column has one value for each sample"),
        (1j * TEN, "run: `b` holds complex numbers"),
        (TEN.astype("datetime64[s]"), "run: `b` holds dates; dates are read as `time_s` alone"),
    ],
)
def test_a_column_that_is_none_is_named(column: Any, message: str) -> None:
    if isinstance(column, list):
        held = np.empty(10, object)
        held[:] = column
        column = held
    with pytest.raises(LogError, match=re.escape(message)):
        ArraySheet("run", {}, ["a", "b"], {"a": TEN, "b": column}, "sample").numbers(["a", "b"])


def test_ten_samples_are_needed() -> None:
    with pytest.raises(LogError, match="run: 9 samples; a log needs at least 10"):
        ArraySheet("run", {}, ["a"], {"a": TEN[:9]}).numbers(["a"])
