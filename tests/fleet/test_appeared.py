"""Effects that few rigs have."""

import polars as pl

from rwjax.fleet.appeared import appeared
from rwjax.fleet.plan import Job
from rwjax.fleet.store import schema
from rwjax.fleet.work import failed


def rows(*given: tuple[str, str, str, list[str]]) -> pl.DataFrame:
    """Results of diagnoses."""
    made = [
        failed(Job(rig, when, "", ()), "diagnose", "") | {"status": "done", "verdict": verdict, "effects": effects}
        for rig, when, verdict, effects in given
    ]
    return pl.DataFrame(made, schema=schema())


def test_an_effect_of_one_rig_is_told_and_one_of_all_is_not() -> None:
    common = [(name, "", "effect", ["axis.coulomb"]) for name in "abc"]
    found = appeared(rows(*common, ("d", "", "effect", ["drive.deadzone"])))
    assert found.rows() == [("d", "", "drive.deadzone", 1, 4)]


def test_what_a_rig_had_before_has_not_appeared() -> None:
    old = [("a", "1", "none", []), ("b", "1", "effect", ["drive.deadzone"])]
    new = [
        ("a", "2", "partial", ["drive.deadzone"]),
        ("b", "2", "effect", ["drive.deadzone"]),
        ("c", "2", "none", []),
        ("d", "2", "none", []),
    ]
    assert appeared(rows(*old, *new)).rows() == [("a", "2", "drive.deadzone", 2, 4)]


def test_what_is_not_claimed_is_not_told() -> None:
    assert appeared(rows(("a", "", "unknown", ["drive.deadzone"]), ("b", "", "none", []))).height == 0


def test_a_set_that_comes_in_another_order_or_with_more_in_it_is_told_by_what_is_new() -> None:
    others = [(name, "1", "none", []) for name in "cdef"]
    old = [("a", "1", "ambiguous", ["drive.deadzone", "axis.coulomb"]), ("b", "1", "effect", ["axis.coulomb"])]
    new = [
        ("a", "2", "ambiguous", ["axis.coulomb", "drive.deadzone"]),
        ("b", "2", "effect", ["axis.coulomb + drive.delay"]),
    ]
    assert appeared(rows(*others, *old, *new)).rows() == [("b", "2", "drive.delay", 1, 6)]
