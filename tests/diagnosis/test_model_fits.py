"""ModelFits: what is kept, and how a fit comes to its end."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from tests.diagnosis.several_runs import run_of, searched
from tests.diagnosis.simulated import fits_of, true_log
from tests.systems import platform

NOTHING, NAMED = Hypothesis(), Hypothesis(("axis.coulomb",))


@pytest.fixture(scope="module")
def fits() -> ModelFits:
    rig = platform()
    found = fits_of(rig, true_log(rig))
    found(NOTHING)
    return found


def test_the_rig_as_it_is_is_fitted_when_first_asked_for(fits: ModelFits) -> None:
    assert NOTHING in fits and fits.ended(NOTHING) and list(fits) == [NOTHING]
    assert fits(NOTHING) is fits.known(NOTHING)
    assert fits(NOTHING).numbers()["axis.inertia"] == pytest.approx(0.1, rel=0.01)
    assert not fits.by_start_rule  # it is complete


def test_a_hypothesis_that_no_search_has_first_fitted_is_refused(fits: ModelFits) -> None:
    assert NAMED not in fits
    with pytest.raises(KeyError, match=r"no search has begun a fit of axis\.coulomb"):
        fits(NAMED)


def test_a_better_fit_is_kept_and_a_worse_one_is_not(fits: ModelFits) -> None:
    known = replace(fits(NOTHING), cost=50.0, steps=3)
    fits.put(NAMED, known)
    fits.keep({NAMED: replace(known, cost=60.0)})
    assert fits.known(NAMED) is known
    better = replace(known, cost=40.0)
    fits.keep({NAMED: better})
    assert fits.known(NAMED) is better and fits.least([NAMED]) == 40.0
    fits.put(NAMED, replace(better, steps=0))
    fits.keep({NAMED: known})  # a fit that took steps is worth more than one that took none
    assert fits.known(NAMED) is known


def test_what_is_opened_again_ends_unless_it_was_bettered(fits: ModelFits) -> None:
    known = replace(fits(NOTHING), cost=50.0, steps=3)
    fits.put(NAMED, known, ended=True)
    ended = fits.reopen([NAMED])
    assert not fits.ended(NAMED)
    fits.close_again(ended)
    assert fits.ended(NAMED)
    ended = fits.reopen([NAMED])
    fits.keep({NAMED: replace(known, cost=40.0)})
    fits.close_again(ended)
    assert not fits.ended(NAMED)


def test_problems_and_spaces_are_made_once(fits: ModelFits) -> None:
    structure = fits(NOTHING).problem.structure
    assert fits.problem_of(NOTHING) is fits.problem_of(NOTHING)
    assert fits.space(NOTHING) is fits.space(NOTHING)
    assert fits.training(structure).structure == structure


def test_a_fit_at_its_end_has_its_derivatives_also_where_a_search_was_stopped_that_bettered_it(fits: ModelFits) -> None:
    bare = replace(fits(NOTHING), evaluation=fits(NOTHING).evaluation._replace(local=np.zeros(0)))
    fits.put(NAMED, bare, ended=True)
    assert fits(NAMED).evaluation.local.size and fits.as_it_stands(NAMED).evaluation.local.size


def test_a_fit_is_taken_as_it_stands_with_its_derivatives(fits: ModelFits) -> None:
    known = replace(fits(NOTHING), evaluation=fits(NOTHING).evaluation._replace(local=np.zeros(0)))
    fits.put(NAMED, known)
    fits.reopen([NAMED])
    found = fits.as_it_stands(NAMED)
    assert fits.ended(NAMED) and np.array_equal(found.theta, known.theta) and found.cost == known.cost
    assert found.evaluation.local.size and fits.as_it_stands(NAMED) is found


def test_the_first_fit_of_the_rig_is_back_for_as_long_as_a_context_lasts() -> None:
    rig = platform()
    fits = fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.05}}))
    fits(NOTHING)
    fits.start_from_first_readings()
    first = fits(NOTHING)
    fits.free_starts_of_what_leads()
    later = fits(NOTHING)
    with pytest.raises(Stopped), fits.as_first_fitted():
        assert fits(NOTHING) is first and fits.by_start_rule
        raise Stopped
    assert fits(NOTHING) is later is not first and not fits.by_start_rule


def test_where_the_budget_ends_the_fits_stay_as_they_are() -> None:
    rig = platform()
    fits = fits_of(rig, true_log(rig))
    fits(NOTHING)
    fits.start_from_first_readings()
    before, budget = fits(NOTHING), fits.headway.budget
    assert fits.by_start_rule  # which the next step would end, since the rig as it is is complete
    budget.stop()
    with budget.searching():
        for step in (
            fits.free_starts,
            fits.free_starts_of_what_leads,
            lambda: fits.finish([NOTHING]),
            lambda: fits.carry_on([NOTHING], 1e-9),
        ):
            with pytest.raises(Stopped):
                step()
            assert fits.by_start_rule and fits.known(NOTHING) is before and fits.ended(NOTHING)
    fits.free_starts()
    assert not fits.by_start_rule


def test_first_states_of_what_leads_are_free_where_a_search_goes_on_though_nothing_is_complete() -> None:
    """A slow motion that nothing explains stands in the first half second, too: the start rule takes it for a first rate."""
    search = searched([run_of(k, {"axis.coulomb": {"M_c": 0.06}}, disturbed=0.03) for k in range(2)], NAMED)
    fits, before = search.fits, {e: search.fits.known(e) for e in (NOTHING, NAMED)}
    fits.free_starts()
    assert fits.by_start_rule  # far from complete
    fits.free_starts_of_what_leads()
    assert not fits.by_start_rule and all(fits.ended(e) and fits.known(e).cost < f.cost for e, f in before.items())
    after = fits.known(NAMED)
    fits.free_starts_of_what_leads()
    assert fits.known(NAMED) is after  # they are free already
