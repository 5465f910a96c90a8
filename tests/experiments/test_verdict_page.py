"""The tables of docs/verdict.md and docs/measured.md are those of the stored results."""

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments import verdict_page
from experiments.blind.score import Judged
from experiments.speed.table import Table
from experiments.standing import worth_of_pair
from experiments.verdict_page import BLOCKS, PAGES, written
from rwjax.diagnosis.verdict import CLAIMS


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_the_page_is_what_the_command_writes(path: Path) -> None:
    page = path.read_text()
    assert written(page) == page, "run python -m experiments.verdict_page"


def test_every_table_stands_on_a_page_once_and_no_other() -> None:
    pages = "".join(path.read_text() for path in PAGES)
    assert all(pages.count(f"<!-- table: {name} -->\n") == 1 for name in BLOCKS)
    assert pages.count("<!-- table: ") == len(BLOCKS)


def test_answers_of_several_sets_are_judged_by_what_the_oracle_said_of_their_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    files = {"one": [{"group": "none", "index": 7, "at": 0}], "other": [{"group": "none", "index": 7, "at": 1}]}
    monkeypatch.setattr(verdict_page, "lines", files.__getitem__)
    monkeypatch.setattr(verdict_page.standing, "FILES", {"none": ("one", "other")})
    told = {"one": {}, "other": {7: {frozenset({"axis.spring"})}}}
    monkeypatch.setattr(verdict_page, "told_by_the_oracle", told.__getitem__)

    def table(among: Sequence[dict], alike: Judged) -> Table:
        return Table("", [], [[str(line["at"]), str(len(alike[line["index"]]))] for line in among])

    assert verdict_page.of_newest(table)().table.rows == [["0", "0"], ["1", "1"]]


def test_every_claim_of_a_pair_is_counted_as_one() -> None:
    for line in verdict_page.lines(verdict_page.PAIRS):
        worth = worth_of_pair(line)
        assert (worth in verdict_page.OF_PAIRS) == (
            (line["verdict"] in CLAIMS and bool(line["changed"])) or worth == "wrong"
        )


def test_what_is_written_by_hand_stays() -> None:
    page = "By hand, | too |.\n\n<!-- table: by-kind -->\nan old table\n<!-- end -->\nMore by hand.\n"
    before, after = (part in written(page) for part in ("By hand, | too |.\n\n<!--", "<!-- end -->\nMore by hand.\n"))
    assert before and after and "an old table" not in written(page) and "| platform | 31 |" in written(page)


@pytest.mark.parametrize(
    ("page", "message"),
    [
        ("<!-- table: shapes -->\n<!-- end -->", "no table is called shapes"),
        ("<!-- table: by-kind -->\n| a |\n", "has no end"),
        ("<!-- table: by-kind -->\n| a |\n<!-- table: worth -->\n<!-- end -->", "has no end"),
    ],
)
def test_a_marker_that_leads_nowhere_is_refused(page: str, message: str) -> None:
    with pytest.raises(SystemExit, match=message):
        written(page)


def test_the_line_above_a_table_names_the_commits_that_a_file_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(verdict_page, "SIMULATED", tmp_path)
    one = {"group": "none", "kind": "wheel", "verdict": "none", "seconds": 1.0}
    for name, commits in (("of_commits", ("abc1234", "abc1234", "def5678-dirty")), ("of_old", (None,))):
        text = "".join(json.dumps(one | ({"commit": c} if c else {})) + "\n" for c in commits)
        (tmp_path / f"{name}.jsonl").write_text(text)
    assert verdict_page.source("of_commits") == "`of_commits.jsonl` (commit `abc1234` in 2, `def5678-dirty` in 1)"
    assert verdict_page.source("of_old") == "`of_old.jsonl`"
    with pytest.raises(SystemExit, match="holds no results"):
        verdict_page.source("of_none")
