"""Comparison by runs: what does not follow the runs that were left out does not lead, whatever the evidence says."""

from dataclasses import replace

import pytest

from rwjax.diagnosis.comparison_by_runs import ComparisonByRuns
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.left_out import LeftOut
from rwjax.diagnosis.settings import PartialSettings, Settings
from tests.diagnosis.several_runs import run_of, searched

BIAS, PERIODIC = Hypothesis(("axis.bias_torque",)), Hypothesis(("axis.periodic_torque",))
TRUTH = {"axis.bias_torque": {"T": 0.02}, "axis.periodic_torque": {"s": 0.15, "c": 0.0, "omega": 1.0}}


def comparison(runs: int) -> ComparisonByRuns:
    """Of a bias and a periodic torque, the larger of which is periodic."""
    return ComparisonByRuns(searched([run_of(k, TRUTH) for k in range(runs)], BIAS, PERIODIC).fits)


def test_what_every_run_shows_leads_and_is_needed() -> None:
    by_runs = comparison(3)
    assert by_runs.leader([BIAS, PERIODIC]) == PERIODIC and by_runs.needs(PERIODIC, NOTHING)
    assert by_runs.leaves_more(BIAS, PERIODIC) and not by_runs.leaves_more(PERIODIC, BIAS)


def test_what_does_not_follow_left_out_runs_does_not_lead_and_is_not_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a torque with several numbers that goes with one run which holds nearly all of the error, and with no other."""
    by_runs, left = comparison(2), {NOTHING: 100.0, BIAS: 30.0, PERIODIC: 120.0}
    monkeypatch.setattr(LeftOut, "excess", lambda _, hypothesis: left[hypothesis])
    assert by_runs.leader([BIAS, PERIODIC]) == BIAS and by_runs.in_sample.leader([BIAS, PERIODIC]) == PERIODIC
    assert not by_runs.needs(PERIODIC, NOTHING) and by_runs.in_sample.needs(PERIODIC, NOTHING)
    assert by_runs.leaves_more(PERIODIC, BIAS) and not by_runs.in_sample.leaves_more(PERIODIC, BIAS)
    assert not by_runs.leaves_more(BIAS, PERIODIC) and by_runs.in_sample.leaves_more(BIAS, PERIODIC)
    left[PERIODIC] = 50.0  # less than twice as much: the evidence decides
    assert by_runs.leader([BIAS, PERIODIC]) == PERIODIC


def test_only_those_that_leave_least_of_the_fitted_runs_may_lead(monkeypatch: pytest.MonkeyPatch) -> None:
    by_runs, left = comparison(2), {BIAS: 1.0, PERIODIC: 120.0}
    by_runs.fits.settings = replace(Settings(), partial=PartialSettings(by_runs=1))
    monkeypatch.setattr(LeftOut, "excess", lambda _, hypothesis: left[hypothesis])
    assert by_runs.leader([BIAS, PERIODIC]) == PERIODIC


def test_of_a_single_run_the_evidence_alone_says_what_leads() -> None:
    by_runs = comparison(1)  # with few independent readings
    by_runs.fits.settings = replace(Settings(), partial=PartialSettings(needed_of_squares=0.0))
    assert by_runs.leader([BIAS, PERIODIC]) == PERIODIC and by_runs.needs(PERIODIC, NOTHING)


@pytest.mark.parametrize(
    ("left", "without", "needed", "likelier"),
    [
        (29.0, 100.0, 0.0, True),
        (30.0, 100.0, 0.0, False),
        (29.0, 100.0, 1e9, False),  # it gains too little altogether
        (0.01, 0.1, 0.0, False),  # there was nothing to follow
    ],
)
def test_a_small_gain_by_the_reading_is_enough_for_a_further_name_that_removes_most_of_left_out_runs(
    left: float, without: float, needed: float, likelier: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = BIAS.plus("axis.periodic_torque")
    by_runs = ComparisonByRuns(searched([run_of(k, TRUTH) for k in range(2)], BIAS, both).fits)
    limits = PartialSettings(needed=needed, needed_by_reading=1e9, needed_of_squares=-1e9)
    by_runs.fits.settings = replace(Settings(), partial=limits)
    excess = {both: left, BIAS: without, NOTHING: 1e3 * without}
    monkeypatch.setattr(LeftOut, "excess", lambda _, e: excess[e])
    assert by_runs.likelier(both, BIAS) == likelier
    assert not by_runs.in_sample.likelier(both, BIAS)
    assert not by_runs.likelier(BIAS, NOTHING)  # which is no further name
