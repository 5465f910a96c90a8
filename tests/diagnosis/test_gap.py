"""The gap: its closure, the interval of that, and the headline signal."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.gap import Gap, HeldOut, closure, gap, headline, held_out, limited
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from rwjax.diagnosis.settings import GapSettings
from tests.diagnosis.simulated import TIME, fits_of, true_log
from tests.systems import platform


def test_closure_is_the_share_of_the_gap_above_the_floor() -> None:
    assert closure(1.0, 0.2, 0.2) == 1.0
    assert closure(1.0, 1.0, 0.2) == 0.0
    assert closure(0.2, 0.2, 0.2) is None


def errors(square: np.ndarray, seconds: int, runs: int = 1) -> HeldOut:
    second, run = (np.repeat(np.arange(n), len(square) // n) for n in (seconds, runs))
    floor = np.full(len(square), 0.01)
    return HeldOut({"yaw_rad": square}, {"yaw_rad": floor}, {"yaw_rad": run}, {"yaw_rad": second}, {})


def test_what_these_runs_close_at_most_is_surer_the_more_seconds_there_are() -> None:
    rng, beyond = np.random.default_rng(0), []
    for seconds in (10, 160):
        before = 1.0 + rng.random(seconds).repeat(50)
        after = 0.2 * before + 0.05 * rng.random(len(before))
        found = gap(errors(before, seconds), errors(after, seconds), "yaw_rad", GapSettings())
        assert (
            found.at_most is not None and found.closed is not None and found.ci95 is None
        )  # one run tells of no other
        beyond.append(found.at_most - found.closed)
    assert beyond[1] == pytest.approx(beyond[0] / 4.0, rel=0.6)  # as the root of sixteen times the seconds


@pytest.mark.parametrize("runs", [3, *(pytest.param(runs, marks=pytest.mark.slow) for runs in (5, 12))])
@pytest.mark.parametrize("left", [0.0, pytest.param(0.02, marks=pytest.mark.slow), 0.2])
def test_the_interval_for_new_runs_holds_what_very_many_of_them_close(runs: int, left: float) -> None:
    rng, holds, tries, floor = np.random.default_rng(runs), 0, 1500, 0.01
    true = closure(np.sqrt(np.exp(0.08)), np.sqrt(floor + left * np.exp(0.125)), 0.1)  # means of lognormal squares
    for _ in range(tries):
        before, after = np.exp(0.4 * rng.standard_normal(runs)), left * np.exp(0.5 * rng.standard_normal(runs))
        noise = floor * (1.0 + 0.1 * rng.standard_normal(runs))
        one = (errors(e.repeat(2), runs, runs) for e in (before, after + noise))
        found = gap(*one, "yaw_rad", replace(GapSettings(), resamples=2))
        assert found.ci95 is not None and true is not None
        holds += found.ci95[0] <= true <= found.ci95[1]
    assert 0.9 <= holds / tries <= 0.99


def test_errors_beyond_the_range_of_numbers_are_far_off_and_their_squares_can_be_summed() -> None:
    limits = GapSettings()
    found = limited(np.array([np.nan, np.inf, -np.inf, 1e300, -1e200, 2.0, -0.5]), limits)
    far = limits.diverged
    assert found.tolist() == [far, far, -far, far, -far, 2.0, -0.5] and np.isfinite(np.sum((found / 1e-6) ** 2))


def test_two_runs_tell_of_no_other_ones() -> None:
    one = np.ones(20)
    assert gap(errors(one, 2, 2), errors(0.1 * one, 2, 2), "yaw_rad", GapSettings()).ci95 is None
    assert gap(errors(one, 4, 4), errors(0.1 * one, 4, 4), "yaw_rad", GapSettings()).ci95 == pytest.approx(
        [closure(1.0, np.sqrt(0.1), 0.1)] * 2
    )


def test_a_gap_of_no_size_has_no_closure() -> None:
    square = np.full(100, 0.01)
    found = gap(errors(square, 10), errors(square, 10), "yaw_rad", GapSettings())
    assert found == Gap(found.floor, found.floor, found.floor, None, None, None) and found.floor == pytest.approx(0.1)


def test_a_closure_that_no_resampling_gives_has_no_interval() -> None:
    found = gap(errors(np.full(100, np.inf), 10), errors(np.ones(100), 10), "yaw_rad", GapSettings())
    assert found.ci95 is None and found.at_most is None


def test_the_headline_is_the_output_furthest_above_its_floor() -> None:
    gaps = {"yaw_rad": Gap(2.0, 2.0, 1.0, 0.0, None, None), "current_A": Gap(0.3, 0.3, 0.1, 0.0, None, None)}
    assert headline(gaps) == "current_A"
    assert gaps["yaw_rad"].size == pytest.approx(np.sqrt(3.0))


def test_held_out_errors_of_a_true_rig_are_noise_and_their_floor_says_so() -> None:
    rig = platform()
    fits = fits_of(rig, true_log(rig))
    (found,) = held_out(fits, [Hypothesis()], [((0,), (0,))], with_floor=True)
    assert found.rms("yaw_rad") == pytest.approx(2e-4, rel=0.1)
    assert np.sqrt(np.mean(found.floor["yaw_rad"])) == pytest.approx(2e-4, rel=0.3)
    assert len(np.unique(found.second["yaw_rad"])) == 21 and len(found.error[0]["yaw_rad"]) == len(TIME)


@pytest.mark.slow
def test_errors_of_several_hypotheses_side_by_side_are_those_of_each_alone() -> None:
    rig = platform("viscous = 0.02")
    logs = [replace(true_log(rig, **{"axis.coulomb": {"M_c": m}}), name=f"{m}.csv") for m in (0.03, 0.05)]
    hypotheses = [Hypothesis(), Hypothesis(("axis.coulomb",)), Hypothesis(("axis.bias_torque",))]

    def fits() -> ModelFits:
        found = ModelFits.of(rig, logs, [0, 1])
        found(hypotheses[0])
        SuccessiveHalving(found).fit(hypotheses[1:], hypotheses[0])
        found.end(hypotheses[1:])
        return found

    folds = [((0,), (1,)), ((1,), (0,))]
    together = held_out(fits(), hypotheses, folds, with_floor=False)
    for e, found in zip(hypotheses, together, strict=True):
        (alone,) = held_out(fits(), [e], folds, with_floor=False)
        assert np.array_equal(found.square["yaw_rad"], alone.square["yaw_rad"]) and found.error.keys() == {0, 1}
    assert len({found.rms("yaw_rad") for found in together}) == 3


def test_an_interval_does_not_depend_on_how_many_seconds_are_drawn_at_once() -> None:
    rng = np.random.default_rng(0)
    before, after = (scale * (1.0 + rng.random(350)) for scale in (1.0, 0.3))
    whole = gap(errors(before, 7), errors(after, 7), "yaw_rad", GapSettings()).at_most
    assert gap(errors(before, 7), errors(after, 7), "yaw_rad", GapSettings(at_once=100)).at_most == whole
