"""The checks that every table goes through, and what reads as a number."""

import math

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.logs.read_sheet import read_sheet
from rwjax.logs.sheet import is_number
from rwjax.logs.text_sheet import TextSheet
from tests.logs.texts import HEADER, ROWS


def test_sizes_count_in_their_unit_up_to_the_largest(tmp_path) -> None:
    sheet = TextSheet(tmp_path / "run.csv", {}, ["voltage_V"], 1, ",", [])
    sheet.check_size("voltage_V", np.array([1e6, np.nan, -1e6]), "V")
    sheet.check_size("counts", np.array([-2e6, 2e6]), "V", 0.5)
    for value, factor in ((1.05e6, 1.0), (-1.05e6, 1.0), (2.1e6, 0.5)):
        with pytest.raises(LogError, match="run.csv:3: `x` is .*; a voltage lies between -1e.06 and 1e.06 V"):
            sheet.check_size("x", np.array([0.0, value]), "V", factor)


def test_what_reads_as_a_number() -> None:
    assert all(is_number(text) for text in ("1", " -2.5e3 ", "nan", "inf"))
    assert not any(is_number(text) for text in ("", "1,5", "1O", "much"))


def test_the_first_row_without_a_finite_number_is_named(tmp_path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("\n".join([HEADER, *ROWS]))
    sheet = read_sheet(path)
    sheet.check_finite("voltage_V", np.zeros(12))
    for value, said in ((math.nan, "missing"), (-math.inf, "-inf")):
        with pytest.raises(
            LogError, match=f"run.csv:5: `voltage_V` is {said}; it has to be a finite number in every row"
        ):
            sheet.check_finite("voltage_V", np.where(np.arange(12) >= 3, value, 0.0))
