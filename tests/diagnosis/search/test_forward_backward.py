"""The forward-backward search: what surpasses what, and what begins from where."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.search.forward_backward import ForwardBackward, Search
from rwjax.diagnosis.search.neighbours import exchanges
from rwjax.diagnosis.settings import Settings
from tests.diagnosis.simulated import fits_of, moved_to, true_log
from tests.systems import platform

NOTHING = Hypothesis()
CURVED = ("drive.saturation", "drive.curvature", "parameter.drive.gain")


@pytest.mark.slow
def test_what_many_places_serve_is_searched_from_all_of_them_at_last() -> None:
    rig = platform("viscous = 0.02")
    stop = {"high": 0.3, "low": -1e6, "k": 3.0, "d": 0.5}
    fits = fits_of(rig, true_log(rig, noise=2e-3, **{"axis.end_stop": stop}))
    few, many = Hypothesis(("axis.bias_torque",)), Hypothesis(("axis.end_stop",))
    search = Search(fits, (*few.names, *many.names))
    search.halving.fit([few, many], NOTHING)
    fitted = fits.known(few)
    moved_to(fits, many, {"axis.end_stop.high": 1e6})
    assert search.comparison.excess(many) > 100.0
    search.fit_from_many_places([few, many], [few, many], enough=0.1)
    assert search.comparison.excess(many) < 0.1 and fits.known(few) is fitted  # of which there are two places alone


@pytest.mark.slow
def test_a_choice_gives_way_to_a_better_rival_and_not_the_other_way_round() -> None:
    rig = platform("viscous = 0.02")
    fits = fits_of(rig, true_log(rig, **{"drive.curvature": {"c": 0.2}}))
    search, wrong, right = Search(fits, CURVED), Hypothesis(("drive.saturation",)), Hypothesis(("drive.curvature",))
    search.halving.fit([wrong, right], NOTHING)
    search.halving.fit(exchanges(CURVED, wrong), NOTHING)
    assert search.surpassing(wrong, exchanges(CURVED, wrong)) == right
    assert search.surpassing(right, search.rivals(right)) is None


@pytest.mark.parametrize("needed", [True, False])
def test_a_choice_gives_way_to_what_contains_it_only_where_that_is_needed(
    monkeypatch: pytest.MonkeyPatch, needed: bool
) -> None:
    rig, dry, curved = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",)), Hypothesis(("axis.stribeck",))
    search = Search(fits_of(rig, true_log(rig, **{"axis.coulomb": {"M_c": 0.03}})), (*dry.names, *curved.names))
    search.halving.fit([dry, curved], NOTHING)
    monkeypatch.setattr(search.comparison, "criterion", lambda e, effective: 100.0 if e == curved else 0.0)
    monkeypatch.setattr(search.comparison, "needs", lambda larger, smaller: needed)
    assert search.surpassing(dry, [curved]) == (curved if needed else None)


@pytest.mark.parametrize("choice", ["drive.curvature", "parameter.drive.gain"])
def test_what_is_far_behind_begins_no_more_where_the_choice_reaches_the_noise(
    choice: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, best, names = platform("viscous = 0.02"), Hypothesis((choice,)), (*CURVED, "parameter.axis.inertia")
    asked = replace(Settings().search, rivals_removed=0.0)  # rivals of a wrong choice are asked for, too
    log = true_log(rig, noise=2e-3, **{"drive.curvature": {"c": 0.2}})
    fits = fits_of(rig, log, replace(Settings(), search=asked))
    search = Search(fits, names)
    search.halving.fit([Hypothesis((name,)) for name in names], NOTHING)
    begun: set[Hypothesis] = set()
    monkeypatch.setattr(search.halving, "fit_again", lambda hypotheses, parent: begun.update(hypotheses))
    rivals = search.rivals(best)
    far = {e for e in rivals if fits.known(e).cost > fits.settings.halving.behind * fits.known(best).cost}
    assert far
    assert begun == {*rivals} - (far if choice == "drive.curvature" else set())


def test_one_name_is_chosen_and_what_it_beats_is_ranked_below_it() -> None:
    rig, names = platform("viscous = 0.02"), ("axis.bias_torque", "parameter.drive.gain")
    fits = fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.03}}))
    fits(NOTHING)
    fits.start_from_first_readings()
    choice = ForwardBackward().choose(fits, names)
    assert choice.best.names == ("axis.bias_torque",) and not choice.alternatives
    assert choice.ranking[0] == (choice.best, pytest.approx(1.0))
    assert np.sum([p for _, p in choice.ranking]) == pytest.approx(1.0)
    assert {e.names for e, _ in choice.ranking} == {(), *((name,) for name in names)}
    assert choice.criterion[choice.best] > 5.0 and choice.criterion[NOTHING] == 0.0


def test_no_name_is_added_to_as_many_as_there_may_be() -> None:
    rig = platform("viscous = 0.02")
    log = true_log(rig, **{"axis.bias_torque": {"T": 0.03}, "drive.curvature": {"c": 0.2}})
    search, one = Search(fits_of(rig, log), ("axis.bias_torque", "drive.curvature")), Hypothesis(("drive.curvature",))
    search.halving.fit([one], NOTHING)
    assert search.forward(one, 1) == one and {*search.fits} == {NOTHING, one}
    assert search.forward(one, 2) == one.plus("axis.bias_torque")


def test_a_search_for_pairs_among_one_name_finds_none() -> None:
    rig = platform("viscous = 0.02")
    search = Search(fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.05}})), ("drive.deadzone",))
    assert search.pairs() == [] and search.pair(NOTHING) is None
    assert search.go_on(NOTHING).best == NOTHING
