"""The files of a diagnosis in a folder."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from rwjax import read_diagnosis, read_rig
from rwjax.report.html import FIGURES, write_report
from rwjax.report.results import clear_results, write_answer, write_results
from tests.report.diagnosed import diagnosed, draws_one_figure


def test_everything_is_written_and_goes_away_again(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    written = write_results(diagnosed(), tmp_path)
    assert written == {"report": tmp_path / "report.html"}
    names = {path.name for path in tmp_path.iterdir()}
    assert {"diagnosis.json", "corrected.toml", "report.html", "diagnosis.npz", "motion.png"} <= names
    assert names <= {
        "diagnosis.json",
        "corrected.toml",
        "report.html",
        "diagnosis.npz",
        "mine.txt",
        *(f"{f}.png" for f in FIGURES),
    }
    assert json.loads((tmp_path / "diagnosis.json").read_text())["verdict"] == "effect"
    clear_results(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
    (tmp_path / "report.html").write_text("mine")
    clear_results(tmp_path)
    assert (tmp_path / "report.html").read_text() == "mine"


def test_the_answer_needs_no_page_and_the_page_can_be_drawn_from_it(tmp_path: Path) -> None:
    write_answer(diagnosed(), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"diagnosis.json", "corrected.toml", "diagnosis.npz"}
    assert write_report(read_diagnosis(tmp_path), tmp_path).exists()


@pytest.mark.parametrize("of", [{}, {"effects": ()}, {"effects": (), "complete": False}])
def test_a_corrected_rig_that_is_not_claimed_says_so_and_can_be_read(
    of: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    draws_one_figure(monkeypatch)
    write_results(diagnosed(verdict="unknown", **of), tmp_path)
    said = "not claimed: Unfinished:" if "complete" in of else "not claimed: Unknown:"
    assert (tmp_path / "corrected.toml").read_text().startswith(f"# caution: {said}")
    assert read_rig(tmp_path / "corrected.toml").cautions[0].startswith(said)
    page = (tmp_path / "report.html").read_text()
    assert f"# caution: {said}" in page and "Numbers of what is named" not in page


def test_a_part_that_is_claimed_of_a_search_that_was_ended_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    draws_one_figure(monkeypatch)
    page = write_report(diagnosed(verdict="partial", complete=False), tmp_path).read_text()
    assert "Numbers of what is named" in page and "no claim" not in page


def test_a_rig_file_that_was_not_sure_before_stays_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draws_one_figure(monkeypatch)
    found = diagnosed()
    write_results(replace(found, rig=replace(found.rig, cautions=("not claimed: a",))), tmp_path)
    assert read_rig(tmp_path / "corrected.toml").cautions == ("not claimed: a",)


@pytest.mark.parametrize(("verdict", "part"), [("ambiguous", ""), ("partial", " of a part")])
def test_a_corrected_rig_that_is_one_explanation_of_several_names_the_others(
    verdict: str, part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    draws_one_figure(monkeypatch)
    several = diagnosed(verdict=verdict, alternatives=(("drive.bias",), ("axis.spring", "drive.delay")))
    write_results(several, tmp_path)
    named = " + ".join(several.effects)
    first, _ = (tmp_path / "corrected.toml").read_text().split("\n", 1)
    assert (
        first
        == f"# caution: this is one explanation{part} of several: {named}; or drive.bias; or axis.spring + drive.delay"
    )
    assert read_rig(tmp_path / "corrected.toml").kind == "platform"
    page = (tmp_path / "report.html").read_text()
    assert "is the rig with what is named first, one explanation of several" in page
    assert page.count("<li>the rig lacks") == 3 and "of 3 explanations is true" in page
