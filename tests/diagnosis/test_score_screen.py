"""The score screen: where a candidate's fit begins, and what it is predicted to leave."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.score_screen import Candidate, ScoreScreen
from rwjax.diagnosis.starting_points import candidate_of
from rwjax.fitting.batched_runs import together
from rwjax.fitting.secant import residuals
from tests.diagnosis.simulated import TIME, fits_of, true_log
from tests.systems import platform, record, run

NOTHING = Hypothesis()


def test_a_fit_also_begins_where_the_free_numbers_suit_the_start() -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    fits = fits_of(rig, true_log(rig))
    candidate = candidate_of(fits, Hypothesis(("sensor.scale",)), NOTHING)
    off, first = candidate.off, candidate.starts[0]
    probed = together([residuals(candidate.problem, [off, first], [candidate.first] * 2)])[0]
    screen = ScoreScreen(fits(NOTHING), fits.settings.screening)
    (moved,) = screen.moved(replace(candidate, starts=[first]), probed)
    after = together([residuals(candidate.problem, [moved], [candidate.first])])[0]
    assert np.sum(after**2) < 0.2 * np.sum(probed[1] ** 2)  # what a wrong scale does, another inertia undoes
    assert {candidate.problem.structure.names[k] for k in np.flatnonzero(moved != first)} == {*rig.free}


def test_the_cause_is_predicted_to_leave_the_noise_and_another_candidate_is_not() -> None:
    rig = platform("viscous = 0.02")
    fits = fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 3e-5}}))
    fits(NOTHING)
    fits.start_from_first_readings()
    screen = ScoreScreen(fits(NOTHING), fits.settings.screening)
    names = (
        "axis.bias_torque",
        "parameter.drive.gain",
    )  # so small a torque bends no other number: a prediction is linear
    right, wrong = screen.predict([candidate_of(fits, Hypothesis((name,)), NOTHING) for name in names])
    readings = fits.problem.batch.readings
    assert right.predicted == pytest.approx(0.5 * readings, rel=0.2)
    assert wrong.predicted > 5.0 * right.predicted and right.predicted < fits(NOTHING).cost


def test_starts_that_differ_in_amplitudes_alone_add_up() -> None:
    starts = [np.array([1.0, 0.5]), np.array([1.0, -0.5]), np.array([2.0, 0.5])]
    rig = platform()
    problem, none = fits_of(rig, true_log(rig)).problem, np.zeros(2)
    free = np.array([True, True])
    candidate = Candidate(problem, none, none, starts, [], free, np.array([False, True]), np.zeros((2, 2)))
    assert candidate.shapes() == [[0, 1], [2]]


def test_a_threshold_is_probed_as_it_is_and_never_in_proportion() -> None:
    rig, dead, u = platform("viscous = 0.02"), Hypothesis(("drive.deadzone",)), 0.9 * np.sin(1.3 * TIME)
    jump = 0.03 * np.sqrt(np.mean(u**2))  # one of those that are tried
    y = run(rig, record(TIME, u), {}, effects={"drive.deadzone": {"j": jump}})["yaw_rad"]
    y += np.random.default_rng(0).normal(0.0, 2e-4, len(y))
    fits = fits_of(rig, record(TIME, u, {"yaw_rad": y}))
    candidate = candidate_of(fits, dead, NOTHING)
    lost, j = map(candidate.problem.structure.names.index, ("drive.deadzone.u_0", "drive.deadzone.j"))
    assert candidate.amplitude[lost] and not candidate.amplitude[j]
    (found,) = ScoreScreen(fits(NOTHING), fits.settings.screening).predict([candidate])
    assert found.begin[0][j] == pytest.approx(jump) and found.begin[0][lost] == 0.0
    assert found.predicted < 0.1 * fits(NOTHING).cost
