"""The report's page: it holds the sentence and the figures, and escapes what comes from files."""

import json
import os
import re
import resource
from collections import Counter
from dataclasses import replace
from functools import partial
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import matplotlib
import pytest
from markupsafe import escape

from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.localise.where import Where
from rwjax.diagnosis.result import Left, Ranked
from rwjax.diagnosis.worst_windows import Window
from rwjax.errors import InputError
from rwjax.logs.log import Segments
from rwjax.report.html import check_page, figures_of, is_page, write_report
from rwjax.report.motions import motions
from tests.report.diagnosed import MARK, diagnosed, draws_one_figure

NAMES = (
    r"a$\foo$.csv",
    "a$$.csv",
    "日本.csv",
    os.fsdecode(b"run\xff.csv"),
    "</text></svg><script>&\"'\x1b[31m\x00\u202e\n.csv",
    "n" * 250,
)
"""What a file may be called."""


def test_where_nothing_was_compared_no_evidence_is_told(tmp_path: Path) -> None:
    page = write_report(diagnosed(verdict="unknown", effects=(), ranking=(Ranked("none", 1.0, None),)), tmp_path)
    assert "No candidate was compared." in page.read_text() and "share of the evidence" not in page.read_text()


def test_a_diagnosis_has_the_figures_that_it_can_fill() -> None:
    assert list(figures_of(diagnosed())) == ["motion", "waterfall", "runs", "missing", "shares", "ranking"]
    found = diagnosed(verdict="none", effects=(), waterfall=diagnosed().waterfall[:1])
    assert list(figures_of(found)) == ["motion", "runs", "ranking"]
    alone = diagnosed(verdict="unknown", effects=(), ranking=(Ranked("none", 1.0, None),))
    assert "ranking" not in figures_of(alone)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a diagnosis, beside its figures."""
    return write_report(diagnosed(), tmp_path_factory.mktemp("page"))


def test_a_number_at_an_end_of_its_range_is_said_to_be_there(tmp_path: Path) -> None:
    last = diagnosed().waterfall[-1]
    found = replace(last, own={"drive.deadzone.u_0": (0.2, 0.01), "drive.deadzone.j": (0.0, float("inf"))})
    page = write_report(diagnosed(waterfall=(diagnosed().waterfall[0], found)), tmp_path).read_text()
    assert "<td>0.2 ± 0.01</td>" in page and "<td>0 (the least that it may be)</td>" in page


def test_a_page_holds_the_sentence_the_figures_and_no_open_name(written: Path) -> None:
    found, page = diagnosed(), written.read_text()
    assert page.index(f"<h1>{found.sentence}</h1>") < page.index("<svg") and found.sentence.startswith("The rig lacks")
    assert page.count('<svg role="img" aria-labelledby="') == page.count("<svg") == 6 and {
        file.name for file in written.parent.glob("*.png")
    } == {f"{name}.png" for name in figures_of(found)}
    assert MARK not in page.replace("<p>rig <b>", "") and "bench &lt;b&gt;&amp;" in page
    assert "a remark &lt;b&gt;&amp;" in page and "a &lt;b&gt;&amp;.csv" in page
    assert "<td>yaw_rad (headline)</td><td>0.5</td><td>0.11</td><td>0.1</td><td>rad</td>" in page
    assert "90.0 % to 99.0 %" in page


def test_of_a_gap_that_hardly_exists_the_page_tells_no_share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draws_one_figure(monkeypatch)
    found = diagnosed()
    write_report(replace(found, gaps=found.gaps | {"yaw_rad_s": Gap(1.05, 0.93, 1.0, 2.4, None, None)}), tmp_path)
    text = (tmp_path / "report.html").read_text()
    assert text.count("no gap to close") == 1 and "97.5 %" in text and "240.0 %" not in text


def test_a_page_counts_runs_and_beside_them_segments(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draws_one_figure(monkeypatch)
    first, second = diagnosed().logs
    goes_on = replace(second, segments=Segments(1.0, "", 1))
    for logs, said in (((first, second), "2 runs, held out"), ((first, goes_on), "1 run in 2 segments, held out")):
        write_report(diagnosed(logs=logs), tmp_path)
        assert said in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize("verdict", ["effect", "ambiguous", "partial"])
def test_under_partial_the_page_says_beside_both_tables_that_the_errors_are_too_tight(
    verdict: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    draws_one_figure(monkeypatch)
    write_report(diagnosed(verdict=verdict), tmp_path)
    said = "The ± below are too tight: under <code>partial</code> the model is known to lack something more."
    assert (tmp_path / "report.html").read_text().count(said) == 2 * (verdict == "partial")


def test_a_file_that_is_no_page_is_never_replaced_and_a_page_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    draws_one_figure(monkeypatch)
    check_page(tmp_path)
    path = write_report(diagnosed(), tmp_path)
    page = path.read_text()
    assert is_page(path) and write_report(diagnosed(), tmp_path).read_text() == page
    path.write_text(page.replace("<title>rwjax: ", "<title>"))
    assert is_page(path)
    path.write_text(page.replace('<meta name="generator" content="rwjax diagnosis">', ""))  # as before there was one
    assert is_page(path)
    for other in (page[1:], f"<!doctype html><html>{500 * ' '}{page}", "<title>rwjax: notes</title>", ""):
        path.write_text(other)
        assert not is_page(path)
    path.write_text("<html>mine</html>")
    for refuses in (check_page, partial(write_report, diagnosed())):
        with pytest.raises(
            InputError, match="report.html: is no page that rwjax wrote, and would be replaced; move that file"
        ):
            refuses(tmp_path)
    assert path.read_text() == "<html>mine</html>" and not is_page(path)


def test_to_draw_a_page_leaves_the_backend_of_figures_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draws_one_figure(monkeypatch)
    backend = matplotlib.get_backend()
    write_report(diagnosed(), tmp_path)
    assert matplotlib.get_backend() == backend


def test_a_page_carries_what_its_script_draws_and_the_script_itself(written: Path) -> None:
    found, page = diagnosed(), written.read_text()
    (held,) = re.findall(r'<script type="application/json" id="motions">(.*?)</script>', page)
    assert json.loads(held) == motions(found) and MARK in json.loads(held)[0]["name"]
    assert (
        "var uPlot" in page
        and "new uPlot(" in page
        and "Leon Sorokin" in page
        and not re.findall(r"""(?:src|href)=["']?http""", page)
    )
    for name in re.findall(r'getElementById\("(.*?)"\)', page):
        assert f'id="{name}"' in page, name
    assert page.index('id="zoom"') < page.index('id="motion"') < page.index("var uPlot")


def test_what_is_left_has_a_place_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draws_one_figure(monkeypatch)
    windows = (Window(f"a {MARK}.csv", 1.0, 2.0, 0.4),)
    left = Left(0.2, Where("time", 0.3, None, None, {"time": 0.3}, ()), windows)
    ranking = (*diagnosed().ranking[:1], Ranked("drive.lag", 0.1, 0.3, f"It leaves more {MARK}."))
    page = write_report(diagnosed(verdict="partial", left=left, ranking=ranking), tmp_path).read_text()
    assert "not the whole answer: it leaves 20 % of the excess squared error; nearest to it comes a law in time" in page
    assert page.count(f"a {escape(MARK)}.csv</td><td>1.00</td><td>2.00</td><td>40.0 %</td>") == 1
    assert f"It leaves more {escape(MARK)}." in page
    assert page.index("Only in part") < page.index("<svg") and "The rig lacks" not in page
    assert "not the whole answer" not in write_report(diagnosed(), tmp_path).read_text()


class Tags(HTMLParser):
    """Counts the tags of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.count: Counter[str] = Counter()
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.count[tag] += 1


def test_names_from_files_are_text_in_page_and_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draws_one_figure(monkeypatch)

    def page_of(*names: str) -> str:
        plain, every = diagnosed(), " ".join(names)
        errors = dict.fromkeys(range(len(names)), plain.before.error[0])
        found = {
            "rig": replace(plain.rig, name=every),
            "logs": tuple(replace(plain.logs[0], name=name) for name in names),
            "before": replace(plain.before, error=errors),
            "after": replace(plain.after, error=errors),
            "remarks": names,
            "held_out": every,
        }
        return write_report(diagnosed(**found), tmp_path).read_text()

    page = page_of(*NAMES)  # tests take a warning, such as of a letter that the font lacks, as an error
    assert Tags(page).count == Tags(page_of(*["run.csv"] * len(NAMES))).count
    assert not [c for c in page if not c.isprintable() and c != "\n"]
    (svg,) = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    drawn = [text.strip() for text in ElementTree.fromstring(svg).itertext()]
    begins = (*NAMES[:3], r"run\udcff.csv", "</text></svg><script>&", "n" * 39 + "…")
    assert all(any(text.startswith(begin) for text in drawn) for begin in begins), drawn


def test_an_earlier_page_stays_where_the_disk_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draws_one_figure(monkeypatch)
    write_report(diagnosed(), tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limit[1]))  # the system refuses to write more
    try:
        with pytest.raises(InputError, match="runs.png: cannot be written: File too large; give a path"):
            write_report(diagnosed(), tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.slow
def test_the_same_diagnosis_makes_the_same_page(written: Path, tmp_path: Path) -> None:
    assert write_report(diagnosed(), tmp_path).read_bytes() == written.read_bytes()


def test_a_page_that_cannot_be_written_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draws_one_figure(monkeypatch)
    (tmp_path / "report.html").mkdir()
    with pytest.raises(InputError, match="report.html: is a folder; give the path of a file"):
        write_report(diagnosed(), tmp_path)
