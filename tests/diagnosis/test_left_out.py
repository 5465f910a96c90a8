"""Left-out runs: what the other runs say is right or wrong there."""

from dataclasses import replace

import numpy as np

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.left_out import LeftOut
from tests.diagnosis.several_runs import run_of, searched

BIAS = Hypothesis(("axis.bias_torque",))
PUSHED = {"axis.bias_torque": {"T": 0.02}}


def test_a_run_that_is_left_out_is_followed_by_what_the_others_say() -> None:
    left_out = searched([run_of(k, PUSHED) for k in range(3)], BIAS).left_out
    without, with_it = left_out(NOTHING), left_out(BIAS)
    assert len(without) == 3 and all(with_it[run] < 0.01 * without[run] for run in without)
    assert 100.0 * left_out.excess(BIAS) < left_out.excess(NOTHING)
    opposite = [run_of(0, PUSHED), run_of(1, PUSHED), run_of(2, {"axis.bias_torque": {"T": -0.02}})]
    left_out = searched(opposite, BIAS).left_out
    assert left_out(BIAS)[2] > left_out(NOTHING)[2]


def test_the_rig_as_it_is_leaves_of_a_run_what_its_prediction_misses() -> None:
    logs = [run_of(k, PUSHED) for k in range(2)]
    left_out = searched(logs, BIAS).left_out  # no number of the rig is free: nothing is fitted anew
    readings = sum(len(log.time) for log in logs)
    assert np.isclose(left_out.excess(NOTHING), sum(left_out(NOTHING).values()) / readings - 1.0)
    assert min(left_out(NOTHING).values()) > readings


def test_another_fit_is_judged_anew() -> None:
    search = searched([run_of(k, PUSHED) for k in range(2)], BIAS)
    first = search.left_out(BIAS)
    assert search.left_out(BIAS) is first
    search.fits.put(BIAS, replace(search.fits(BIAS)), ended=True)
    assert search.left_out(BIAS) is not first


def test_a_single_run_cannot_be_left_out() -> None:
    left_out = LeftOut(searched([run_of(0, PUSHED)], BIAS).fits)
    assert left_out.runs == {} and left_out(BIAS) == {} and left_out.excess(BIAS) == 0.0
