"""The report's page: it holds the sentence and the figures, and escapes what comes from files."""

import math
from pathlib import Path

import matplotlib
import pytest

from rwjax.errors import InputError
from rwjax.report.html import figures_of, percent, short, signed, write_report
from tests.report.diagnosed import MARK, diagnosed


def test_numbers_are_short_and_missing_ones_dashes() -> None:
    assert [short(1.0 / 3.0), short(None), short(math.inf)] == ["0.3333", "–", "–"]
    assert [percent(0.1234), percent(None), percent(math.nan)] == ["12.3 %", "–", "–"]
    assert [signed(1.26), signed(-0.04), signed(math.inf)] == ["+1.3", "-0.0", "–"]


def test_a_diagnosis_has_the_figures_that_it_can_fill() -> None:
    assert list(figures_of(diagnosed())) == ["runs", "waterfall", "missing", "shares", "ranking"]
    found = diagnosed(verdict="none", effects=(), waterfall=diagnosed().waterfall[:1])
    assert list(figures_of(found)) == ["runs", "ranking"]


def test_a_page_holds_the_sentence_the_figures_and_no_open_name(tmp_path: Path) -> None:
    found = diagnosed()
    backend = matplotlib.get_backend()
    page = write_report(found, tmp_path).read_text()
    assert page.index(f"<h1>{found.sentence}</h1>") < page.index("<svg") and found.sentence.startswith("The rig lacks")
    assert page.count("<svg") == 5 and {file.name for file in tmp_path.glob("*.png")} == {
        f"{name}.png" for name in figures_of(found)
    }
    assert MARK not in page.replace("<p>rig <b>", "") and "bench &lt;b&gt;&amp;" in page
    assert "a remark &lt;b&gt;&amp;" in page and "a &lt;b&gt;&amp;.csv" in page
    assert "<td>yaw_rad (headline)</td><td>0.5</td><td>0.11</td><td>0.1</td><td>rad</td>" in page
    assert "90.0 % to 99.0 %" in page and matplotlib.get_backend() == backend


def test_the_same_diagnosis_makes_the_same_page(tmp_path: Path) -> None:
    pages = []
    for name in "ab":
        (tmp_path / name).mkdir()
        pages.append(write_report(diagnosed(), tmp_path / name).read_text())
    assert pages[0] == pages[1]


def test_a_page_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    (tmp_path / "report.html").mkdir()
    with pytest.raises(InputError, match="report.html: is a folder; give the path of a file"):
        write_report(diagnosed(), tmp_path)
