"""Going on: what a search that goes on begins from."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.comparison_by_runs import ComparisonByRuns
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.left_out import LeftOut
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.fitting.multiple_shooting import Fit
from tests.diagnosis.several_runs import run_of, searched
from tests.diagnosis.simulated import moved_to

DRY, BIAS = Hypothesis(("axis.coulomb",)), Hypothesis(("axis.bias_torque",))
BOTH = {"axis.coulomb": {"M_c": 0.06}, "axis.bias_torque": {"T": 0.02}}


def test_a_second_name_is_found_beside_the_first() -> None:
    search = searched([run_of(k, BOTH) for k in range(3)], DRY, BIAS)
    assert search.go_on(DRY).best == DRY.plus(*BIAS.names)


@pytest.mark.parametrize(("left", "first"), [(400.0, BIAS), (2500.0, DRY)])
def test_it_begins_from_what_leaves_less_than_half_of_left_out_runs_where_these_decide(
    left: float, first: Hypothesis, monkeypatch: pytest.MonkeyPatch
) -> None:
    truth = {"axis.coulomb": {"M_c": 0.06}, "axis.bias_torque": {"T": 0.03}}
    search, begun = searched([run_of(k, truth) for k in range(2)], DRY, BIAS), []
    monkeypatch.setattr(LeftOut, "excess", lambda _, e: left if e == BIAS else 1000.0)
    monkeypatch.setattr(ComparisonByRuns, "needs", lambda *_: True)
    monkeypatch.setattr(search, "forward", lambda hypothesis, most: begun.append(hypothesis) or hypothesis)
    search.go_on(DRY)
    assert begun == [first]


def test_it_begins_from_a_larger_set_that_was_tried_among_the_rivals(monkeypatch: pytest.MonkeyPatch) -> None:
    pair, begun = DRY.plus(*BIAS.names), []
    search = searched([run_of(k, BOTH) for k in range(2)], DRY, pair)
    monkeypatch.setattr(search, "forward", lambda hypothesis, most: begun.append(hypothesis) or hypothesis)
    assert search.go_on(DRY).best == pair
    assert begun == [pair]


def looks_around_the_first_fit(
    monkeypatch: pytest.MonkeyPatch, look: Callable[[FurtherSearch], object]
) -> FurtherSearch:
    """A search that finds no second name but by a look around the first fit."""
    search = searched([run_of(k, BOTH) for k in range(2)], DRY, BIAS)
    search.limits = replace(search.limits, beginnings=0)
    monkeypatch.setattr(search, "forward", lambda hypothesis, most: hypothesis)
    monkeypatch.setattr(search, "pairs", list)
    monkeypatch.setattr(search, "fit_pairs_around_the_first_fit", lambda: look(search))
    return search


def test_a_pair_that_shows_around_the_first_fit_leads_where_a_visible_part_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pair, looks = DRY.plus(*BIAS.names), []

    def look(search: FurtherSearch) -> None:
        looks.append(search.settled.best)
        search.halving.fit([pair], NOTHING)

    search = looks_around_the_first_fit(monkeypatch, look)
    assert search.go_on(DRY).best == pair == search.settled.best and looks == [DRY]
    assert search.go_on(pair).best == pair and len(looks) == 1


def test_what_had_led_is_known_where_the_budget_ends_a_look_around_the_first_fit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def look(search: FurtherSearch) -> None:
        raise Stopped

    search = looks_around_the_first_fit(monkeypatch, look)
    with pytest.raises(Stopped):
        search.go_on(DRY)
    assert search.settled.best == DRY


@pytest.mark.parametrize(("beginnings", "names"), [(0, 1), (4, 2)])
def test_a_second_name_is_looked_for_beside_each_leading_one(
    beginnings: int, names: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = searched([run_of(k, BOTH) for k in range(2)], DRY, BIAS)
    search.limits = replace(search.limits, beginnings=beginnings)
    monkeypatch.setattr(search, "forward", lambda hypothesis, most: hypothesis)
    monkeypatch.setattr(search, "fit_pairs_around_the_first_fit", lambda: None)
    monkeypatch.setattr(search, "pairs", list)
    assert len(search.go_on(BIAS).best.names) == names


@pytest.mark.parametrize(("leave", "beside"), [(1e-3, 1), (1e6, 2)])
def test_none_is_looked_for_beside_a_name_that_leaves_many_times_as_much_as_the_choice(
    leave: float, beside: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    search, looked = searched([run_of(k, BOTH) for k in range(2)], DRY, BIAS), []
    search.limits = replace(search.limits, beginnings_leave=leave)
    monkeypatch.setattr(search, "forward", lambda hypothesis, most: hypothesis)
    monkeypatch.setattr(search, "fit_pairs_around_the_first_fit", lambda: None)
    monkeypatch.setattr(search, "pairs", list)
    monkeypatch.setattr(search, "announce", lambda tried, hypothesis, passes=0: looked.append(hypothesis))
    search.go_on(BIAS)
    assert len(looked) == beside and {*looked} <= {DRY, BIAS}


def test_what_follows_left_out_runs_worse_does_not_lead_though_it_has_more_names(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pair = DRY.plus(*BIAS.names)
    search = searched([run_of(k, BOTH) for k in range(2)], DRY, pair)
    monkeypatch.setattr(LeftOut, "excess", lambda _, e: 1500.0 if e == pair else 1000.0)
    assert search.go_on(DRY).best == DRY


def test_a_pair_that_began_at_a_poor_place_is_fitted_from_all_others(monkeypatch: pytest.MonkeyPatch) -> None:
    pair, poor = DRY.plus(*BIAS.names), []
    search = searched([run_of(k, BOTH) for k in range(2)], DRY, BIAS)
    halved = search.halving.fit

    def at_a_poor_place(tried: Sequence[Hypothesis], parent: Hypothesis) -> dict[Hypothesis, Fit]:
        found = halved(tried, parent)
        if pair in found:
            moved_to(search.fits, pair, {"axis.coulomb.M_c": 0.2, "axis.bias_torque.T": -0.1}, ended=True)
            poor.append(search.fits.known(pair).cost)
        return found

    monkeypatch.setattr(search, "forward", lambda hypothesis, most: hypothesis)
    monkeypatch.setattr(search, "fit_pairs_around_the_first_fit", lambda: None)
    monkeypatch.setattr(search, "pairs", list)
    monkeypatch.setattr(search.halving, "fit", at_a_poor_place)
    monkeypatch.setattr(search, "given_way", lambda best: (best, []))
    search.go_on(BIAS)
    assert search.fits.known(pair).cost < 0.1 * poor[0]
