"""Kinds of run: each is in the recommended campaign and shows something."""

from rwjax.effects.library import EFFECTS
from rwjax.effects.shown import RUNS
from rwjax.planning.campaign import DESIGNS


def test_every_kind_of_run_is_in_the_campaign_and_shows_an_effect() -> None:
    assert {design.shows for design in DESIGNS.values()} - {""} == {*RUNS}
    assert {run for effect in EFFECTS for run in effect.shown_by} == {*RUNS}
    assert all(RUNS.values())
