"""The page of a fleet."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import polars as pl
import pytest

from rwjax.fleet.page import Fleet, numbers_of, outcomes, write_fleet
from rwjax.fleet.plan import FleetPlan, Job
from rwjax.fleet.told import told
from rwjax.fleet.work import NOTHING
from tests.fleet.test_changes import fleet


def shown(rows: pl.DataFrame) -> Fleet:
    """What the page shows."""
    return told(FleetPlan("fit", {}, tuple(Job(*one, "", ()) for one in rows.select("rig", "when").iter_rows())), rows)


MOVED = fleet(40, np.random.default_rng(1), {3: np.array([0.0, 1e-3])})


def test_the_page_names_the_rig_that_changed_and_draws_every_number(tmp_path: Path) -> None:
    found = shown(MOVED)
    text = write_fleet(found, tmp_path, lambda row: None).read_text()
    assert "1 of 40 rigs differ from their siblings or from themselves." in text
    assert (
        text.count("<figure") == 3
        and "r0003" in text
        and "http"
        not in text.replace("http://www.w3.org", "")
        .replace("https://www.w3.org", "")
        .replace("http://purl.org", "")
        .replace("http://creativecommons.org", "")
        .replace("https://matplotlib.org", "")
    )
    for svg in text.split("<svg")[1:]:
        ElementTree.fromstring("<svg" + svg.split("</svg>")[0] + "</svg>")


def test_the_lines_say_the_same() -> None:
    lines = str(shown(MOVED)).split("\n")
    assert lines[0].startswith("1 of 40 rigs differ")
    assert any(line.startswith("  r0003, 2 differs from itself: axis.friction.coulomb by +0.00") for line in lines)


def test_the_fleets_numbers_stand_on_the_page(tmp_path: Path) -> None:
    found = shown(MOVED)
    assert found.pooled.fleet["number"].to_list() == ["axis.inertia", "axis.friction.coulomb"]
    assert found.pooled.fleet["rigs"].to_list() == [39, 39]  # the one that differs does not count
    text = write_fleet(found, tmp_path, lambda row: None).read_text()
    assert '<td class="words">axis.friction.coulomb</td>' in text and "numbers.csv" in text


def test_one_session_is_drawn_over_rigs(tmp_path: Path) -> None:
    text = write_fleet(shown(MOVED.filter(when="2")), tmp_path, lambda row: None).read_text()
    assert "rig, by name" in text


def test_outcomes_are_counted() -> None:
    rows = MOVED.head(3).with_columns(
        verdict=pl.Series(["effect", "effect", "none"]), effects=pl.Series([["drive.delay"], ["drive.delay"], []])
    )
    assert outcomes(rows) == {"effect: drive.delay": 2, "none": 1}
    assert numbers_of(rows) == ["axis.friction.coulomb", "axis.inertia"] and numbers_of(rows.head(0)) == []


def test_rigs_that_cannot_be_compared_are_not_said_to_be_sound() -> None:
    assert (
        shown(MOVED.filter(pl.col("rig") < "r0004")).sentence
        == "4 rigs, of which too few tell numbers to be compared: that takes 8, as do the fleet's numbers."
    )
    one_failed = MOVED.with_columns(status=pl.when(pl.col("rig") == "r0009").then(pl.lit("failed")).otherwise("status"))
    assert "1 was not compared; 2 of 80 jobs failed." in shown(one_failed).sentence


@pytest.mark.parametrize(
    ("command", "rigs", "sentence"),
    [
        ("check", 1, "1 rig; 1 of 1 job failed."),
        ("compare", 2, "2 rigs; 2 of 2 jobs failed."),
        (
            "fit",
            1,
            "1 rig, of which too few tell numbers to be compared: that takes 8, as do the fleet's numbers; 1 of 1 job failed.",
        ),
    ],
)
def test_one_is_said_as_one(command: str, rigs: int, sentence: str) -> None:
    rows = MOVED.filter(when="2").head(rigs).with_columns(status=pl.lit("failed"))
    assert shown(rows)._replace(command=command).sentence == sentence


def test_the_best_methods_of_comparisons_are_counted(tmp_path: Path) -> None:
    rows = MOVED.filter(when="2").head(3)
    methods = pl.Series(["end-to-end", "weak form", "end-to-end"])
    found = shown(rows.with_columns(command=pl.lit("compare"), verdict=methods))._replace(command="compare")
    assert str(found).split("\n") == [
        "3 rigs.",
        "  best on held-out data: end-to-end: 2",
        "  best on held-out data: weak form: 1",
    ]
    page = write_fleet(found, tmp_path, lambda row: None).read_text()
    assert '<td class="words">best on held-out data: end-to-end</td><td>2</td>' in page


@pytest.mark.parametrize("command", ["fit", "compare"])
def test_rigs_whose_logs_tell_nothing_are_counted_by_themselves(command: str) -> None:
    rows = MOVED.filter(when="2").head(2).with_columns(command=pl.lit(command), verdict=pl.Series([NOTHING, None]))
    assert outcomes(rows) == {"the logs tell nothing": 1}


def test_what_hides_changes_is_said() -> None:
    assert shown(MOVED).notes == []
    worse = MOVED.with_columns(misfit=pl.lit(5.0))
    assert [note[:40] for note in shown(worse).notes] == ["80 of 80 fits miss their readings by mor"]
    few = MOVED.filter((pl.col("when") == "2") | (pl.col("rig") < "r0004"))
    assert [note[:34] for note in shown(few).notes] == ["only 4 rigs have two sessions, too"]
