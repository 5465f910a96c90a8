"""The table of what is asked and reached counts what its rows say."""

import re

import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments import verdict_page
from experiments.standing import ROWS, Row, newest, standing

ANSWERS = {
    "fourth": [{"group": "single", "hit": True}, {"group": "single", "hit": None}, {"group": "none", "hit": True}],
    "measured": [{"hit": False}],
}


def test_a_row_counts_the_answers_of_its_groups_and_files_that_count() -> None:
    rows = [Row("hits", "90 %", ("single", "measured"), lambda line, _: line["hit"])]
    assert standing(ANSWERS.__getitem__, lambda _: {}, rows).rows == [
        ["hits", "90 %", "2", "50.0 % (1.3 to 98.7)", "`fourth`, `measured`"]
    ]


def test_every_row_has_cases_and_no_case_is_counted_twice() -> None:
    assert all(int(row[2]) > 0 for row in verdict_page.where_it_stands().table.rows)
    for row in ROWS:
        cases = [
            (line.get("set"), line.get("index"), line.get("name"), line.get("data"))
            for _, line in newest(verdict_page.lines, row.cases)
        ]
        assert len(cases) == len({*cases})


def test_the_readme_says_what_the_table_says() -> None:
    readme = (verdict_page.ROOT / "README.md").read_text().partition("## How often it is right")[2]
    reached = {row[3] for row in verdict_page.where_it_stands().table.rows}
    told = re.findall(r"[\d.]+ % \([\d.]+ to [\d.]+\)", readme.partition("\n* ")[0])
    assert len(told) > 8 and {*told} <= reached


def test_two_causes_count_where_each_is_large_without_the_other() -> None:
    two = next(row for row in ROWS if row.what.startswith("two causes"))
    told = {line["index"]: two.counted(line, {}) for line in verdict_page.lines("fourth") if line["group"] == "pair"}
    assert told[125] is True and told[126] is False  # 11.3 and 7.3 without the smaller cause
    assert told[122] is None  # 3.8
