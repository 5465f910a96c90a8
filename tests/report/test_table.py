"""Columns as CSV text."""

import math

import numpy as np
import pytest

from rwjax.report.table import csv


def test_numbers_have_ten_digits_and_words_stay() -> None:
    columns = {"kp": np.array([1.0, 1.0 / 3.0]), "time_s": [math.inf, 2e-12], "limit": np.array(["current", "voltage"])}
    assert csv(columns) == "kp,time_s,limit\n1,inf,current\n0.3333333333,2e-12,voltage\n"


def test_what_has_no_value_is_an_empty_cell() -> None:
    assert csv({"kp": [1.0, 2.0], "modulus": np.array([np.nan, 0.5])}) == "kp,modulus\n1,\n2,0.5\n"


def test_columns_of_different_length_are_refused() -> None:
    with pytest.raises(ValueError, match="zip"):
        csv({"a": [1.0], "b": [1.0, 2.0]})
