"""The forward-backward search: what surpasses what, and what begins from where."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log
from rwjax.diagnosis.exact_fits import fit_exactly
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.forward_backward import ForwardBackward, Search
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.diagnosis.search.neighbours import exchanges
from rwjax.diagnosis.settings import Settings
from tests.diagnosis.simulated import fits_of, moved_to, true_log
from tests.systems import platform, reaction, record, run

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
def test_of_what_is_fitted_side_by_side_nothing_counts_after_the_first_that_suffices() -> None:
    rig, names = platform("viscous = 0.02"), ("axis.coulomb", "axis.bias_torque", "axis.spring")
    usual = Settings()
    fits = fits_of(
        rig,
        true_log(rig, **{"axis.coulomb": {"M_c": 0.03}}),
        replace(usual, search=replace(usual.search, many_places=0, from_all_places_at_once=2)),
    )
    search, singles = Search(fits, names), [Hypothesis((name,)) for name in names]
    search.halving.fit(singles, NOTHING)
    for single, number, value in zip(singles, ("M_c", "T", "k"), (0.02, 0.01, 0.01), strict=True):
        moved_to(fits, single, {f"{single.names[0]}.{number}": value})
    first, second, third = sorted(singles, key=lambda e: fits.known(e).cost)
    assert first.names == ("axis.coulomb",)
    before = {e: fits.known(e) for e in singles}
    together = search.halving.from_all_places([first, second], NOTHING)
    assert all(search.halving.from_all_places([e], NOTHING)[e].cost == found.cost for e, found in together.items())
    assert together[second].cost < before[second].cost  # it would be better, too
    search.fit_from_many_places(singles, singles, enough=0.1)
    assert search.comparison.excess(first) < 0.1
    assert fits.known(second) is before[second] and fits.known(third) is before[third]


def test_what_leads_above_the_noise_is_fitted_from_all_its_places_however_little_it_leaves() -> None:
    rig, usual = platform("viscous = 0.02"), Settings()
    asked = replace(
        usual, search=replace(usual.search, negligible=0.999)
    )  # what is left counts as the exact form of any name
    log = true_log(rig, noise=2e-3, **{"axis.coulomb": {"M_c": 0.03}})
    fits = fits_of(rig, log, asked)
    dry, slope = (Hypothesis((name,)) for name in ("axis.coulomb", "parameter.drive.gain"))
    search = Search(fits, (*dry.names, *slope.names))
    search.halving.fit([dry, slope], NOTHING)
    fits.take_down(NOTHING, [dry, slope])
    least = fits.known(dry).cost
    moved_to(fits, dry, {"axis.coulomb.M_c": 0.0})  # where it has come to a place that is not its best
    assert fits.known(dry).cost > fits.known(slope).cost
    assert search.forward(NOTHING, 1) == dry
    assert fits.known(dry).cost <= 1.01 * least


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
    monkeypatch.setattr(search.comparison, "leaves_more", lambda one, other: False)
    assert search.surpassing(dry, [curved]) == (curved if needed else None)


@pytest.mark.parametrize("choice", [pytest.param("drive.curvature", marks=pytest.mark.slow), "parameter.drive.gain"])
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
    far -= {e for e in far if search.comparison.removed(e) >= search.limits.again_removed}
    assert far
    assert begun == {*rivals} - (far if choice == "drive.curvature" else set())


def test_a_rival_that_was_left_behind_on_its_way_begins_again_where_it_removes_most_of_the_error() -> None:
    """Two delays are the same thing on a rig that starts at rest; the fit of one had not come to its end when the other sufficed."""
    rig, found, left = platform("viscous = 0.02"), Hypothesis(("sensor.delay",)), Hypothesis(("drive.delay",))
    fits = fits_of(rig, true_log(rig, noise=1e-3, **{"drive.delay": {"tau": 0.03}}))
    search = Search(fits, (*found.names, *left.names))
    search.halving.fit([found, left], NOTHING)
    fit_exactly(fits, [found])
    moved_to(fits, left, {"axis.inertia": 0.1, "axis.friction.viscous": 0.02, "drive.delay.tau": 0.022})
    assert fits.known(left).cost > fits.settings.halving.behind * fits.known(found).cost
    assert left in search.rivals(found)
    assert fits.known(left).cost < 1.1 * fits.known(found).cost
    assert search.chosen(found, [left]).alternatives == (left,)


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


@pytest.mark.slow
def test_no_name_is_added_to_as_many_as_there_may_be() -> None:
    rig = platform("viscous = 0.02")
    log = true_log(rig, **{"axis.bias_torque": {"T": 0.03}, "drive.curvature": {"c": 0.2}})
    search, one = Search(fits_of(rig, log), ("axis.bias_torque", "drive.curvature")), Hypothesis(("drive.curvature",))
    search.halving.fit([one], NOTHING)
    assert search.forward(one, 1) == one and {*search.fits} == {NOTHING, one}
    assert search.forward(one, 2) == one.plus("axis.bias_torque")


def test_a_search_for_pairs_among_one_name_finds_none() -> None:
    rig = platform("viscous = 0.02")
    search = FurtherSearch(fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.05}})), ("drive.deadzone",))
    assert search.pairs() == []
    assert search.go_on(NOTHING).best == NOTHING


def push_and_delay(number: int) -> Log:
    """A testbed with a bias torque and a short delay; a slow motion that no effect makes hides what yaw would tell of small things."""
    time, rng = np.arange(1501) * 0.01, np.random.default_rng(number)
    volts = (2.0 + number) * np.sign(np.sin((1.7 + 0.2 * number) * time)) + np.sin(5.0 * time)
    command, asked = np.where(time > 0.6, volts, 0.0), dict.fromkeys(("yaw_rad", "wheel_rad_s"), np.zeros_like(time))
    missing = {"axis.bias_torque": {"T": 0.002}, "drive.delay": {"tau": 0.01}}
    y = run(reaction(), record(time, command, asked), {}, effects=missing)
    walk = np.cumsum(np.cumsum(rng.normal(size=len(time))) * (time > 0.6))
    yaw = y["yaw_rad"] + 0.1 * walk / np.max(np.abs(walk)) + rng.normal(0.0, 1e-3, len(time))
    return record(time, command, {"yaw_rad": yaw, "wheel_rad_s": y["wheel_rad_s"] + rng.normal(0.0, 0.5, len(time))})


@pytest.mark.slow
def test_what_removes_most_is_chosen_though_another_output_has_more_evidence() -> None:
    """The wheel's speed tells the delay by thousands of independent readings, and the delay leaves nearly all of yaw's error."""
    push, late = Hypothesis(("axis.bias_torque",)), Hypothesis(("drive.delay",))
    fits = ModelFits.of(reaction(), [push_and_delay(k) for k in range(2)], range(2))
    fits(NOTHING)
    fits.start_from_first_readings()
    search = Search(fits, (*push.names, *late.names))
    choice, compare = search.run(), search.comparison
    assert choice.criterion[late] > choice.criterion[push]
    assert compare.excess(late) > 0.9 * compare.excess(NOTHING) and compare.leaves_more(late, push)
    assert choice.best == push and not choice.alternatives
    assert search.surpassing(push, [late]) is None and search.surpassing(late, [push]) == push
    both = push.plus(*late.names)
    search.halving.fit([both], push)
    fit_exactly(fits, [both])
    assert not compare.needs(both, push) and not compare.needs(both, late)  # either may be dropped
    assert search.backward(both) == push


@pytest.mark.parametrize("needed", [True, False])
def test_a_rival_keeps_a_spare_name_where_even_the_choice_that_it_surpasses_is_needed_in_place_of_the_rest(
    needed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = platform("viscous = 0.02")
    search = Search(fits_of(rig, true_log(rig, **{"axis.coulomb": {"M_c": 0.03}})), ())
    one, choice, rival = Hypothesis(("a",)), Hypothesis(("a", "b")), Hypothesis(("a", "c"))
    monkeypatch.setattr(search, "backward", lambda e: one if e == rival else e)
    monkeypatch.setattr(search, "rivals", lambda best: [rival])
    monkeypatch.setattr(search, "surpassing", lambda best, rivals: rival if best == choice else None)
    monkeypatch.setattr(
        search.comparison, "needs", lambda larger, smaller: needed and (larger, smaller) == (choice, one)
    )
    assert search.exchanged(choice)[0] == (rival if needed else one)
