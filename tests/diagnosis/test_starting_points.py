"""Starting points: where a hypothesis may begin."""

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.score_screen import ScoreScreen
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving, fitted
from rwjax.diagnosis.starting_points import begin, candidate_of
from tests.diagnosis.simulated import fits_of, moved_to, true_log
from tests.systems import platform, record, run, wheel

NOTHING = Hypothesis()


def test_two_places_that_no_run_tells_apart_are_one() -> None:
    rig, stopped = platform("viscous = 0.02\ncoulomb = 0.03"), Hypothesis(("axis.end_stop",))
    fits = fits_of(rig, true_log(rig, **{"axis.end_stop": {"high": 0.8, "low": -1e6, "k": 40.0, "d": 1.5}}))
    fits(NOTHING)
    fits.start_from_first_readings()
    screen = ScoreScreen(fits(NOTHING), fits.settings.screening)
    (screened,) = screen.predict([candidate_of(fits, stopped, NOTHING)])
    begun = begin(fits, [stopped], NOTHING)[stopped]
    costs = np.array([f.cost for f in begun.places])
    assert len(costs) < len(screened.begin)  # what no run reaches may lie anywhere
    assert np.all(np.diff(costs) > 1e-9 * costs[:-1])
    assert begun.predicted == screened.predicted and np.array_equal(begun.here.theta, screened.theta)
    assert stopped not in fits  # nothing is taken down


@pytest.mark.parametrize("times", [0.15, 0.25, 4.5, 5.5])
def test_a_hypothesis_also_begins_where_the_rig_file_says_if_its_parent_went_far_from_it(times: float) -> None:
    rig, named = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",))
    fits = fits_of(rig, true_log(rig))
    fits(NOTHING)
    assert not len(candidate_of(fits, named, NOTHING).unprobed)
    moved_to(fits, NOTHING, {"axis.inertia": 0.1 * times}, ended=True)
    candidate = candidate_of(fits, named, NOTHING)
    k = candidate.problem.structure.names.index("axis.inertia")
    assert bool(candidate.unprobed) == (abs(np.log(times)) > np.log(5.0))
    assert all(theta[k] == 0.1 for theta in candidate.unprobed)
    assert all(theta[k] == 0.1 * times for theta in candidate.starts)


@pytest.mark.parametrize(("high", "hides"), [(0.8, True), (None, False)])
def test_what_the_estimates_without_it_hide_begins_at_the_rig_files_numbers_too(
    high: float | None, hides: bool
) -> None:
    """The parent is so heavy that no run reaches a stop near the furthest reading; dry friction acts wherever a run moves."""
    rig = platform("viscous = 0.02")
    named = Hypothesis(("axis.end_stop",) if hides else ("axis.coulomb",))
    effects = {"axis.end_stop": {"high": high, "low": -1e6, "k": 40.0, "d": 1.5}} if high else {}
    fits = fits_of(rig, true_log(rig, **effects))
    fits(NOTHING)
    moved_to(fits, NOTHING, {"axis.inertia": 0.3}, ended=True)
    places = begin(fits, [named], NOTHING)[named].places
    k = places[0].problem.structure.names.index("axis.inertia")
    assert 0.3 in {f.theta[k] for f in places} and (0.1 in {f.theta[k] for f in places}) == hides
    assert [f.cost for f in places] == sorted(f.cost for f in places)


def test_a_place_whose_run_leaves_the_range_of_numbers_hides_none_at_which_it_does_not() -> None:
    rig, dry, time = wheel(), Hypothesis(("wheel.coulomb",)), np.arange(801) * 0.01
    volts = np.where(time > 0.6, 6.0 * np.sign(np.sin(1.7 * time)), 0.0)
    speed = run(rig, record(time, volts, {"wheel_rad_s": np.zeros(801)}), {})["wheel_rad_s"]
    fits = ModelFits.of(rig, [record(time, volts, {"wheel_rad_s": speed + 0.02 * np.sin(1e3 * time)})], [0])
    fits(NOTHING)
    moved_to(fits, NOTHING, {"wheel.inertia": 4e-8, "motor.friction": 0.05}, ended=True)
    places = begin(fits, [dry], NOTHING)[dry].places
    k = places[0].problem.structure.names.index("wheel.inertia")
    assert np.all(np.isfinite([f.cost for f in places]))
    assert rig.values["wheel.inertia"] in [f.theta[k] for f in places]


def test_a_limit_begins_at_the_numbers_of_the_effect_that_it_limits() -> None:
    rig = platform("viscous = 0.02")
    play, elastic = Hypothesis(("axis.backlash",)), Hypothesis(("axis.flexible_coupling",))
    fits = fits_of(rig, true_log(rig))
    SuccessiveHalving(fits).fit([play], NOTHING)
    handed = candidate_of(fits, elastic, play).unprobed[-1]
    names = candidate_of(fits, elastic, play).problem.structure.names
    for name in ("s", "k", "c"):
        assert handed[names.index(f"axis.flexible_coupling.{name}")] == fits(play).numbers()[f"axis.backlash.{name}"]


def test_a_wrong_number_is_tried_at_several_factors_and_probed() -> None:
    rig, wrong = platform("viscous = 0.02"), Hypothesis(("parameter.drive.gain",))
    fits = fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.03}}))
    candidate = candidate_of(fits, wrong, NOTHING)
    k = candidate.problem.structure.names.index("drive.gain")
    assert np.allclose(sorted(theta[k] / 0.4 for theta in candidate.unprobed), [0.5, 0.7, 1.0, 1.4, 2.0])
    assert candidate.amplitude[k] and candidate.off[k] == 0.4 and candidate.starts[0][k] != 0.4


def test_what_is_predicted_to_leave_far_more_than_its_parent_begins_nowhere_unless_it_was_fitted_before() -> None:
    rig = platform("viscous = 0.02")
    dry, pushed, spring = (Hypothesis((name,)) for name in ("axis.coulomb", "axis.bias_torque", "axis.spring"))
    fits = fits_of(rig, true_log(rig, **{"axis.coulomb": {"M_c": 0.06}}))
    fits(NOTHING)
    fits.start_from_first_readings()
    SuccessiveHalving(fits).fit([dry, pushed], NOTHING)
    begun = begin(fits, [pushed, spring, NOTHING], dry, behind=20.0)
    assert min(begun[e].predicted for e in (pushed, spring)) > 20.0 * fits(dry).cost
    assert begun[pushed].places and begun[NOTHING].places and not begun[spring].places
    assert begin(fits, [spring], dry)[spring].places


def test_what_has_begun_nowhere_counts_as_not_fitted_and_is_fitted_later() -> None:
    rig = platform("viscous = 0.02")
    dry, spring = (Hypothesis((name,)) for name in ("axis.coulomb", "axis.spring"))
    fits = fits_of(rig, true_log(rig, **{"axis.coulomb": {"M_c": 0.06}}))
    fits(NOTHING)
    fits.start_from_first_readings()
    halving = SuccessiveHalving(fits)
    halving.fit([dry], NOTHING)
    before = halving.fit([spring], dry)[spring]
    assert spring in fits and not fits.stepped(spring)
    assert fits.stepped(dry)
    after = fitted(fits, spring)
    assert fits.stepped(spring) and after.cost < before.cost
