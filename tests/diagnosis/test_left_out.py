"""Left-out runs: what the other runs say is right or wrong there."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.left_out import LeftOut
from rwjax.diagnosis.refits import refitted
from rwjax.fitting.prediction import predict_logs
from tests.diagnosis.several_runs import run_of, searched

BIAS = Hypothesis(("axis.bias_torque",))
PUSHED = {"axis.bias_torque": {"T": 0.02}}


def test_a_run_that_is_left_out_is_followed_by_what_the_others_say() -> None:
    left_out = searched([run_of(k, PUSHED) for k in range(3)], BIAS).by_runs.left_out
    without, with_it = left_out(NOTHING), left_out(BIAS)
    assert len(without) == 3 and all(with_it[run] < 0.01 * without[run] for run in without)
    assert 100.0 * left_out.excess(BIAS) < left_out.excess(NOTHING)
    opposite = [run_of(0, PUSHED), run_of(1, PUSHED), run_of(2, {"axis.bias_torque": {"T": -0.02}})]
    left_out = searched(opposite, BIAS).by_runs.left_out
    assert left_out(BIAS)[2] > left_out(NOTHING)[2]


def test_what_is_left_of_a_run_is_what_the_numbers_of_the_other_one_miss() -> None:
    logs = [run_of(k, PUSHED) for k in range(2)]
    left_out = searched(logs, BIAS).by_runs.left_out
    fits = left_out.fits
    (noise,) = fits.problem.noise.values()
    for k, theta in enumerate(refitted(fits, [(NOTHING, [1]), (NOTHING, [0])])):
        missed = logs[k].outputs["yaw_rad"] - predict_logs(fits.problem, theta)[k].outputs["yaw_rad"]
        assert np.isclose(left_out(NOTHING)[k], np.sum((missed / noise) ** 2))


def test_another_fit_is_judged_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    search, asked = searched([run_of(k, PUSHED) for k in range(2)], BIAS), []
    monkeypatch.setattr(
        "rwjax.diagnosis.left_out.refitted", lambda fits, cases: asked.append(cases) or refitted(fits, cases)
    )
    left_out = search.by_runs.left_out
    first = left_out(BIAS)
    assert left_out(BIAS) == first and len([cases for cases in asked if cases]) == 1
    search.fits.put(BIAS, replace(search.fits(BIAS)), ended=True)
    assert left_out(BIAS) == first and len([cases for cases in asked if cases]) == 2


@pytest.mark.parametrize("error", [np.nan, -np.inf, 1e300])
def test_a_left_out_run_that_runs_away_counts_as_far_off_and_can_still_be_summed(
    error: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    left_out = searched([run_of(k, PUSHED) for k in range(2)], BIAS).by_runs.left_out
    (noise,) = left_out.fits.problem.noise.values()
    monkeypatch.setattr(
        "rwjax.diagnosis.left_out.errors",
        lambda problem, predictions: [
            {name: np.full(len(y), error) for name, y in problem.logs[p.log].outputs.items()} for p in predictions
        ],
    )
    far = left_out.fits.settings.gap.diverged / noise
    assert left_out.excess(NOTHING) == pytest.approx(far**2)


def test_a_single_run_cannot_be_left_out() -> None:
    left_out = LeftOut(searched([run_of(0, PUSHED)], BIAS).fits)
    assert left_out.runs == {} and left_out(BIAS) == {} and left_out.excess(BIAS) == 0.0
