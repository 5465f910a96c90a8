"""Model comparison: which hypothesis leads, and how much error each one leaves."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from rwjax.fitting.batched_runs import together
from rwjax.fitting.secant import with_derivatives
from tests.diagnosis.simulated import fits_of, moved_to, true_log
from tests.systems import platform

NOTHING = Hypothesis()


@pytest.mark.slow
def test_a_play_of_nothing_is_the_coupling_that_it_hands_its_numbers_to() -> None:
    rig, true = platform("viscous = 0.02"), {"s": 0.6, "k": 60.0, "c": 0.1}
    fits = fits_of(rig, true_log(rig, **{"axis.flexible_coupling": true}))
    play, elastic = Hypothesis(("axis.backlash",)), Hypothesis(("axis.flexible_coupling",))
    halving = SuccessiveHalving(fits)
    halving.fit([play], NOTHING)
    moved_to(fits, play, {f"axis.backlash.{name}": value for name, value in (true | {"g": 0.0}).items()})
    fits.put(play, together([with_derivatives(fits.known(play))])[0])
    halving.fit([elastic], play)
    found = fits.known(elastic)
    assert {name: found.numbers()[f"axis.flexible_coupling.{name}"] for name in true} == pytest.approx(true, rel=0.1)
    assert ModelComparison(fits).leader([play, elastic]) == elastic


def test_the_cause_leads_is_needed_and_removes_all_of_the_excess() -> None:
    rig, right, wrong = platform("viscous = 0.02"), Hypothesis(("axis.bias_torque",)), Hypothesis(("axis.coulomb",))
    fits = fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.03}}))
    fits(NOTHING)
    fits.start_from_first_readings()
    SuccessiveHalving(fits).fit([right, wrong], NOTHING)
    compare = ModelComparison(fits)
    assert compare.excess(NOTHING) > 100.0 and compare.excess(right) < 0.1
    assert compare.leaves_something(NOTHING) and not compare.leaves_something(right)
    assert compare.removed(right) == pytest.approx(1.0, abs=0.02) and compare.removed(NOTHING) == 0.0
    assert compare.leader([NOTHING, wrong, right]) == right and compare.needs(right, NOTHING)
    assert compare.compared[:3] == (NOTHING, right, wrong)
    both = right.plus("axis.coulomb")
    SuccessiveHalving(fits).fit([both], right)
    assert not compare.needs(both, right) and compare.leader([right, both]) == right
    assert compare.ties(wrong, right) and not compare.ties(right, wrong)  # only what misses the noise may tie
    effective = compare.effective(right)
    assert compare.gain(right, NOTHING) == pytest.approx(
        compare.criterion(right, effective) - compare.criterion(NOTHING, effective)
    )
    order = [e for e, _ in compare.probabilities([wrong, NOTHING, right], effective)]
    assert order[0] == right and np.isclose(sum(p for _, p in compare.probabilities([wrong, right], effective)), 1.0)


@pytest.mark.parametrize(("richer", "leads"), [(9.0, "axis.coulomb"), (4.0, "axis.stribeck")])
def test_a_larger_law_leads_where_it_removes_half_of_what_its_special_case_leaves(
    monkeypatch: pytest.MonkeyPatch, richer: float, leads: str
) -> None:
    """A fixed number that is a little off lets the larger law gain some hundred, with numbers at their bounds."""
    rig, dry, curved = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",)), Hypothesis(("axis.stribeck",))
    fits = fits_of(rig, true_log(rig, **{"axis.coulomb": {"M_c": 0.03}}))
    fits(NOTHING)
    SuccessiveHalving(fits).fit([dry, curved], NOTHING)
    compare = ModelComparison(fits)
    monkeypatch.setattr(compare, "excess", {NOTHING: 100.0, dry: 10.0, curved: richer}.__getitem__)
    monkeypatch.setattr(compare, "gain", lambda larger, smaller: 100.0)
    monkeypatch.setattr(compare, "criterion", lambda e, effective: float(len(e.names[0])))  # best for the longer name
    assert compare.leader([dry, curved]).names == (leads,)


def test_two_names_at_once_have_to_remove_half_where_one_name_need_not(monkeypatch: pytest.MonkeyPatch) -> None:
    rig, one = platform("viscous = 0.02"), Hypothesis(("axis.bias_torque",))
    both, compare = one.plus("drive.deadzone"), ModelComparison(fits_of(rig, true_log(rig)))
    left = {NOTHING: 100.0, one: 70.0, both: 55.0}
    monkeypatch.setattr(compare, "excess", left.__getitem__)
    monkeypatch.setattr(compare, "gain", lambda larger, smaller: 100.0)
    assert compare.needs(one, NOTHING) and not compare.needs(both, NOTHING) and not compare.needs(both, one)
    left[both] = 30.0
    assert compare.needs(both, NOTHING) and compare.needs(both, one)


def test_a_search_that_goes_on_adds_what_removes_less_but_takes_no_richer_law_for_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig, dry, curved = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",)), Hypothesis(("axis.stribeck",))
    both, fits = dry.plus("drive.deadzone"), fits_of(rig, true_log(rig))
    going_on = ModelComparison(fits, fits.settings.partial.further_removes)
    left = {dry: 100.0, curved: 55.0, both: 55.0}
    for compare in (going_on, ModelComparison(fits)):
        monkeypatch.setattr(compare, "excess", left.__getitem__)
        monkeypatch.setattr(compare, "gain", lambda larger, smaller: 100.0)
        assert compare.needs(both, dry) == (compare is going_on) and not compare.needs(curved, dry)
    left[both] = 80.0
    assert not going_on.needs(both, dry)


@pytest.mark.parametrize(("angle", "rate", "tie"), [(1.0, 3.05, True), (1.0, 3.3, False), (1.15, 3.05, False)])
def test_what_is_no_noise_ties_within_a_tenth_unless_an_output_at_the_noise_tells(
    monkeypatch: pytest.MonkeyPatch, angle: float, rate: float, tie: bool
) -> None:
    rig, one, other = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",)), Hypothesis(("axis.bias_torque",))
    log = true_log(rig, **{"axis.coulomb": {"M_c": 0.03}})
    turning = log.outputs | {"yaw_rad_s": np.gradient(log.outputs["yaw_rad"], log.time)}
    fits = fits_of(rig, replace(log, outputs=turning))
    fits(NOTHING)
    SuccessiveHalving(fits).fit([one, other], NOTHING)
    compare, count = ModelComparison(fits), float(len(log.time))
    monkeypatch.setattr(compare, "effective", lambda e: {"yaw_rad": 100.0, "yaw_rad_s": 100.0})
    looked_at = iter([(1.0, 3.0), (angle, rate)])  # mean squares, of `one` first
    monkeypatch.setattr(
        "rwjax.diagnosis.model_comparison.sums_of_squares",
        lambda _: {name: count * mean for name, mean in zip(turning, next(looked_at), strict=True)},
    )
    assert compare.ties(one, other) == tie


@pytest.mark.parametrize(
    ("angle", "rate", "visible"),
    [
        ((2500.0, 1.2), (1600.0, 1600.0), True),  # the name explains one output and does not touch the other
        ((2500.0, 1.2), (1600.0, 1.2), False),
        ((2500.0, 5.0), (1600.0, 1.2), False),  # a twentieth of the error at most, however far from the noise
        ((2500.0, 100.0), (1600.0, 1.2), True),
        ((2500.0, 3.0), (1.0, 3.0), False),  # little of either, but together as much as a gap that is looked into
        ((2500.0, 1.2), (1.0, 6.0), True),  # which the rig itself explained
    ],
)
def test_what_is_left_is_visible_where_an_output_keeps_more_than_a_twentieth_of_its_error(
    monkeypatch: pytest.MonkeyPatch, angle: tuple[float, float], rate: tuple[float, float], visible: bool
) -> None:
    rig, one = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",))
    log = true_log(rig, **{"axis.coulomb": {"M_c": 0.03}})
    turning = log.outputs | {"yaw_rad_s": np.gradient(log.outputs["yaw_rad"], log.time)}
    fits = fits_of(rig, replace(log, outputs=turning))
    fits(NOTHING)
    SuccessiveHalving(fits).fit([one], NOTHING)
    compare, count = ModelComparison(fits), float(len(log.time))
    looked_at = iter(zip(angle, rate, strict=True))  # mean squares, those of the rig as it is first
    monkeypatch.setattr(
        "rwjax.diagnosis.model_comparison.sums_of_squares",
        lambda _: {name: count * mean for name, mean in zip(turning, next(looked_at), strict=True)},
    )
    assert compare.excess(NOTHING) > compare.excess(one)
    assert compare.leaves_visible(one) == visible


@pytest.mark.parametrize(("excess", "something"), [(0.5, True), (0.05, False)])
def test_a_tenth_of_the_noise_is_something(excess: float, something: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = platform("viscous = 0.02")
    compare = ModelComparison(fits_of(rig, true_log(rig)))
    monkeypatch.setattr(ModelComparison, "excess", lambda *_: excess)
    assert compare.leaves_something(NOTHING) == something


def test_motions_are_as_far_apart_as_their_readings_are_whatever_is_missing() -> None:
    """By the reading: rows without one count for nothing."""
    rig = platform("viscous = 0.02")
    log = true_log(rig)
    sparse = replace(log, outputs={n: np.where(np.arange(len(y)) % 10, np.nan, y) for n, y in log.outputs.items()})
    found, other = [], Hypothesis(("axis.coulomb",))
    for each in (log, sparse):
        fits = fits_of(rig, each)
        known = fits(NOTHING)
        read = known.problem.batch.weight > 0.0
        moved = known.evaluation._replace(residual=known.evaluation.residual + 3.0 * read)
        fits.put(other, replace(known, evaluation=moved), ended=True)
        found.append(ModelComparison(fits).apart(NOTHING, other))
    assert found == pytest.approx([9.0, 9.0], rel=0.05)
