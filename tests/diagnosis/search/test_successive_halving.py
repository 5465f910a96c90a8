"""Successive halving: what advances, what begins again, and what a fit from all places finds."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving, extrapolated_cost, fitted
from rwjax.diagnosis.starting_points import Begun, begin
from tests.diagnosis.simulated import fits_of, moved_to, true_log
from tests.systems import platform

NOTHING = Hypothesis()


@pytest.mark.parametrize(
    ("cost", "before", "extrapolated"),
    [
        (50.0, 100.0, 12.5),  # halved, and so twice again
        (2000.0, 8000.0, 125.0),  # far above its parent's 100, on its way
        (100.5, 8000.0, 100.5),  # come down to its parent: it adds nothing and promises nothing
        (80.0, 8000.0, 51.2),  # below it: what it gained on the parent counts
        (90.0, 80.0, 90.0),
        (50.0, np.inf, 12.5),
        (2000.0, np.inf, 2000.0),
    ],
)
def test_what_counts_is_what_a_hypothesis_gains_on_its_parent(cost: float, before: float, extrapolated: float) -> None:
    assert extrapolated_cost(cost, before, 100.0, at_parent=0.01) == pytest.approx(extrapolated)


@pytest.mark.slow
def test_a_rival_that_stands_at_a_wrong_place_begins_again_from_the_choice() -> None:
    rig = platform("viscous = 0.02")
    fits = fits_of(rig, true_log(rig, **{"drive.saturation": {"u_m": 4.0, "n": 2.0}}))
    halving = SuccessiveHalving(fits)
    choice, rival = Hypothesis(("drive.supply_sag",)), Hypothesis(("drive.saturation",))
    halving.fit([choice, rival], NOTHING)
    best = fits.known(rival)
    moved_to(fits, rival, {"drive.saturation.u_m": 1.25, "drive.saturation.n": 5000.0}, ended=True)
    stuck = fits.known(rival).cost
    halving.fit([rival], choice)
    assert fits.known(rival).cost == stuck  # what has come to its end is left alone
    halving.fit_again([rival], choice)
    assert fits.known(rival).cost < 1.1 * best.cost < 0.2 * stuck and fits.ended(rival)
    assert all(len(fits(e).evaluation.local) for e in (choice, rival))  # as a parent of others needs


@pytest.mark.slow
def test_no_number_moves_that_its_hypothesis_leaves_as_the_rig_file_says() -> None:
    rig = platform(free='"axis.friction.viscous"')
    heavy = true_log(rig.with_values({"axis.inertia": 1.1 * rig.numbers["axis.inertia"]}))
    fits, wrong = fits_of(rig, heavy), Hypothesis(("parameter.axis.inertia",))
    halving = SuccessiveHalving(fits)
    halving.fit([wrong], NOTHING)
    halving.fit([NOTHING, Hypothesis(("axis.spring",))], wrong)
    for hypothesis in (NOTHING, Hypothesis(("axis.spring",))):
        assert fits(hypothesis).numbers()["axis.inertia"] == rig.numbers["axis.inertia"]
    assert fits(wrong).numbers()["axis.inertia"] == pytest.approx(1.1 * rig.numbers["axis.inertia"], rel=0.01)


@pytest.mark.slow
def test_a_stop_is_searched_from_every_place_that_differs() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.03")
    stop = {"high": 0.8, "low": -1e6, "k": 40.0, "d": 1.5}
    fits, stopped = fits_of(rig, true_log(rig, **{"axis.end_stop": stop})), Hypothesis(("axis.end_stop",))
    fits(NOTHING)
    fits.start_from_first_readings()
    places = begin(fits, [stopped], NOTHING)[stopped].places
    costs = np.array([f.cost for f in places])
    fits.put(stopped, places[-1])  # as if the rounds had left all others behind
    found = SuccessiveHalving(fits).from_all_places([stopped], NOTHING)[stopped]
    assert fits.known(stopped) is places[-1]
    assert found.cost < 0.05 * costs[0] and found.numbers()["axis.end_stop.high"] == pytest.approx(0.8, abs=0.05)


def test_a_hypothesis_that_no_search_has_begun_is_fitted_from_the_rig_as_it_is() -> None:
    rig, drag = platform("viscous = 0.02"), Hypothesis(("axis.quadratic_drag",))
    fits = fits_of(rig, true_log(rig, **{"axis.quadratic_drag": {"c": 0.01}}))
    assert drag not in fits
    found = fitted(fits, drag)
    assert found.numbers()["axis.quadratic_drag.c"] == pytest.approx(0.01, rel=0.05)
    assert fits.ended(drag) and fitted(fits, drag) is found
    assert SuccessiveHalving(fits).fit([], NOTHING) == {}


def test_what_begins_at_no_place_is_fitted_from_where_it_was_screened(monkeypatch: pytest.MonkeyPatch) -> None:
    rig, dry = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",))
    fits = fits_of(rig, true_log(rig, **{"axis.coulomb": {"M_c": 0.06}}))
    fits(NOTHING)
    fits.start_from_first_readings()

    def nowhere(fits: ModelFits, some: Sequence[Hypothesis], parent: Hypothesis) -> dict[Hypothesis, Begun]:
        return {e: replace(one, places=[]) for e, one in begin(fits, some, parent).items()}

    monkeypatch.setattr("rwjax.diagnosis.search.successive_halving.begin", nowhere)
    found = SuccessiveHalving(fits).from_all_places([dry], NOTHING)[dry]
    assert found.numbers()["axis.coulomb.M_c"] == pytest.approx(0.06, rel=0.05)
