"""What every page shares."""

import math
import re

import pytest
from jinja2 import UndefinedError

from rwjax.report.page import by_chance, code, drawing, percent, rendered_page, short, signed, svg_of


def test_numbers_are_short_and_missing_ones_dashes() -> None:
    assert [short(1.0 / 3.0), short(None), short(math.inf)] == ["0.3333", "–", "–"]
    assert [percent(0.1234), percent(None), percent(math.nan)] == ["12.3 %", "–", "–"]
    assert [signed(1.26), signed(-0.04), signed(math.inf)] == ["+1.3", "-0.0", "–"]


def test_what_chance_gives_is_said_in_words() -> None:
    assert [by_chance(p) for p in (0.9, 0.05, 3e-23, math.nan)] == [
        "often",
        "about 1 in 20",
        "less than 1 in 1000",
        "–",
    ]


def test_a_figure_is_the_same_text_every_time() -> None:
    texts = []
    for _ in range(2):
        with drawing((3.0, 2.0)) as figure:
            figure.subplots().plot([0.0, 1.0], [0.0, 1.0])
            texts.append(svg_of(figure, "one"))
    assert texts[0] == texts[1] and texts[0].lstrip().startswith(("width", "height", "xmlns", "version"))


def test_no_id_of_a_figure_is_that_of_another_and_every_reference_finds_its_own() -> None:
    ids = list[set[str]]()
    for name in ("one", "axis.inertia"):
        with drawing((3.0, 2.0)) as figure:
            figure.subplots().plot([0.0, 1.0], [0.0, 1.0])
            svg = svg_of(figure, name)
        found = re.findall(r'\bid="([^"]+)"', svg)
        assert len(found) == len({*found}) and {*re.findall(r'(?:href="#|url\(#)([^")]+)', svg)} <= {*found}
        assert "#one" not in svg.replace('href="#', "").replace("url(#", "")  # a colour is no reference
        ids.append({*found})
    assert not ids[0] & ids[1]


def test_a_page_without_what_it_shows_is_no_page() -> None:
    with pytest.raises(UndefinedError):
        rendered_page("fleet.html.j2", dict.fromkeys(("report", "change_words"), str))


def test_what_stands_between_backticks_is_code_and_everything_is_text() -> None:
    assert code("take `--a <b>` & `c`") == "take <code>--a &lt;b&gt;</code> &amp; <code>c</code>"
    assert code("one ` alone <b>") == "one ` alone &lt;b&gt;"
