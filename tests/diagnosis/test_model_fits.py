"""ModelFits: what is kept, and how a fit comes to its end."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.settings import Settings
from tests.diagnosis.simulated import TIME, fits_of, true_log
from tests.systems import platform, record, run

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


def test_a_hypothesis_that_no_search_has_begun_is_refused(fits: ModelFits) -> None:
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


def test_a_fit_to_a_fold_begins_from_the_estimates_on_all_logs() -> None:
    rig = platform()
    logs = [true_log(rig), true_log(rig)]
    fits = ModelFits.of(rig, logs, [0, 1])
    inertia = fits.problem.names.index("axis.inertia")
    on_one, on_both = fits.fitted_to([(NOTHING, [0]), (NOTHING, [1, 0])])
    assert on_one[inertia] == pytest.approx(fits(NOTHING).numbers()["axis.inertia"], rel=1e-3)
    assert on_one[inertia] != on_both[inertia] and np.array_equal(on_both, fits(NOTHING).theta)


@pytest.mark.parametrize("by_start_rule", [False, True])
def test_without_one_of_many_runs_the_numbers_move_as_in_a_fit_without_it(by_start_rule: bool) -> None:
    rig, rng = platform("viscous = 0.02", '"axis.inertia", "axis.friction.viscous"'), np.random.default_rng(3)
    logs, time = [], TIME[:201]
    for rate in np.linspace(1.0, 4.0, 8):
        log = record(time, 0.4 * np.sin(rate * time) * (time > 0.6))
        angle = run(rig, log, {})["yaw_rad"] + rng.normal(0.0, 2e-4, len(time))
        logs.append(replace(log, name=f"{rate:g}.csv", outputs={"yaw_rad": angle}))
    cases = [(NOTHING, [k for k in range(8) if k != left]) for left in range(8)]
    moved = []
    for light in (1.0, 0.0):
        settings = replace(Settings(), fitting=replace(Settings().fitting, light_run=light, tolerance=1e-9))
        fits = ModelFits.of(rig, logs, range(8), settings)
        fits(NOTHING)
        if by_start_rule:
            fits.start_from_first_readings()
        moved.append(np.array(fits.fitted_to(cases)) - fits(NOTHING).theta)
    step, fit = moved
    free = [fits.problem.names.index(name) for name in rig.free]
    size = np.sqrt(np.mean(fit[:, free] ** 2, axis=0))
    assert np.all(size > 0.0) and np.all(np.sqrt(np.mean((step - fit)[:, free] ** 2, axis=0)) < 0.05 * size)


def test_a_run_that_tells_much_is_left_out_by_a_fit_though_there_are_many() -> None:
    """A model that lacks dry friction, and one run that is longer than the others together."""
    rig, logs = platform("viscous = 0.02", '"axis.inertia", "axis.friction.viscous"'), []
    for k, samples in enumerate((*[101] * 14, 2001)):
        time = TIME[:samples]
        log = record(time, (0.3 + 0.03 * k) * np.sin((1.0 + 0.2 * k) * time))
        angle = run(rig, log, {}, effects={"axis.coulomb": {"M_c": 0.05}})["yaw_rad"]
        logs.append(replace(log, name=f"{k}.csv", outputs={"yaw_rad": angle}))
    without = [(NOTHING, range(14))]
    found = []
    for light in (Settings().fitting.light_run, 0.0):
        settings = replace(Settings(), fitting=replace(Settings().fitting, light_run=light))
        found.append(ModelFits.of(rig, logs, range(15), settings).fitted_to(without)[0])
    assert np.array_equal(*found)


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


def test_where_the_budget_ends_the_fits_stay_as_they_are() -> None:
    rig = platform()
    fits = fits_of(rig, true_log(rig))
    fits(NOTHING)
    fits.start_from_first_readings()
    before, budget = fits(NOTHING), fits.headway.budget
    assert fits.by_start_rule  # which the next step would end, since the rig as it is is complete
    budget.stop()
    with budget.searching():
        for step in (fits.free_starts, lambda: fits.finish([NOTHING]), lambda: fits.carry_on([NOTHING], 1e-9)):
            with pytest.raises(Stopped):
                step()
            assert fits.by_start_rule and fits.known(NOTHING) is before and fits.ended(NOTHING)
    fits.free_starts()
    assert not fits.by_start_rule
