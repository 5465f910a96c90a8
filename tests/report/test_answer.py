"""The gate of results: what is no finite number is named, and not written."""

import json
import math
import os

import numpy as np
import pytest

from rwjax.errors import InputError
from rwjax.report.answer import check_finite, json_text


def test_finite_numbers_and_what_is_missing_pass() -> None:
    answer = {"schema": "x/1", "k": [1.5, None, (2, True)], "by name": {"a": np.float64(0.1), "b": "text"}}
    assert json.loads(json_text(answer)) == {
        "schema": "x/1",
        "k": [1.5, None, [2, True]],
        "by name": {"a": 0.1, "b": "text"},
    }
    assert json_text({"a": 1}, indent=1) == '{\n "a": 1\n}'


@pytest.mark.parametrize("value", [math.nan, math.inf, np.float64(-math.inf)])
def test_a_number_that_is_not_finite_is_named_by_its_key(value: float) -> None:
    for check in (json_text, check_finite):
        with pytest.raises(
            InputError, match=r"^the result's `gap.signals` would be (nan|inf|-inf), which is no finite number"
        ):
            check({"gap": {"before": 1.0, "signals": [1.0, [value]]}})


def test_a_name_that_is_no_text_is_written_as_utf_8_all_the_same() -> None:
    name = os.fsdecode(b"run\xff.csv")
    text = json_text({name: [name]})
    assert json.loads(text) == {r"run\udcff.csv": [r"run\udcff.csv"]}
    assert json.loads(text)[r"run\udcff.csv"][0].encode("utf-8") == rb"run\udcff.csv"
