"""The campaign of stopped diagnoses: what it counts as wrong, and what as withdrawn."""

import json
from pathlib import Path

import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.anytime.run import answer, claimed, counts, stopped
from experiments.blind.draw import SETS, read

FULL = {"verdict": "effect", "complete": True, "untried": [], "effects": ["a"], "alternatives": []}


def test_what_an_answer_claims() -> None:
    assert claimed(FULL) == {"a"} and claimed(None) == set()
    assert claimed(FULL | {"verdict": "ambiguous", "alternatives": [["b", "c"]]}) == {"a", "b", "c"}
    assert claimed(FULL | {"verdict": "unknown"}) == set()


def test_half_an_answer_is_wrong_and_none_at_all_is_none(tmp_path: Path) -> None:
    assert answer(tmp_path / "none", b"", "rwjax: interrupted\n") == {"answer": None}
    assert "wrong" in answer(tmp_path / "none", b"", "Traceback\n  File\n")
    text = json.dumps(FULL)
    for name in ("diagnosis.json", "corrected.toml", "report.html"):
        (tmp_path / name).write_text(text)
    assert answer(tmp_path, text.encode(), "") == {"answer": FULL}
    assert "wrong" in answer(tmp_path, b"{}", "")
    (tmp_path / "report.html").write_text("")
    assert "wrong" in answer(tmp_path, text.encode(), "")
    (tmp_path / "diagnosis.json").write_text(text[:-9])
    assert "wrong" in answer(tmp_path, text.encode(), "")


def test_the_counts() -> None:
    unfinished = FULL | {"verdict": "unknown", "complete": False}
    stops = [
        {"status": 0, "answer": FULL, "withdrawn": []},
        {"status": 130, "answer": unfinished, "withdrawn": []},
        {"status": 130, "answer": unfinished | {"effects": ["b"]}, "withdrawn": ["b"]},
        {"status": 130, "answer": None, "withdrawn": []},
        {"status": 1, "answer": None, "withdrawn": []},
        {"status": 0, "wrong": "no answer", "withdrawn": []},
    ]
    found = [count for _, count in counts([{"full": {"answer": FULL}, "stops": stops}])]
    assert found == [6, 3, 1, 2, 2, 1, 2, 1]


@pytest.mark.slow
def test_two_stops_of_a_case_give_nothing_wrong() -> None:
    row = next(row for row in read(SETS / "explore.jsonl") if row["kind"] == "wheel" and row["group"] == "single")
    line = stopped(row | {"each": 2})
    assert dict(counts([line]))["with anything wrong"] == 0 and line["full"]["answer"]["complete"]
    assert [stop["withdrawn"] for stop in line["stops"]] == [[], []]
