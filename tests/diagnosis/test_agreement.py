"""Agreement: a true effect has one amplitude in every run and at every size of command, an imitation has not."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.agreement import Amplitude, amplitudes, unevenness
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.fitting.segments import with_segments
from rwjax.logs.segments import cut_up
from tests.diagnosis.several_runs import RIG, TIME, run_of, searched

BIAS = Hypothesis(("axis.bias_torque",))
PUSHED = {"axis.bias_torque": {"T": 0.02}}


def test_a_true_effect_has_one_amplitude_in_every_run_and_at_every_size_of_command() -> None:
    search = searched([run_of(k, PUSHED) for k in range(3)], BIAS)
    found = amplitudes(search.fits, BIAS, NOTHING)
    assert len(found) == 7  # three runs, smaller and larger commands, first and second halves
    assert np.allclose([a.value for a in found], 1.0, atol=0.02) and max(a.error for a in found) < 0.02
    assert np.isclose(sum(a.weight for a in found[:3]), 1.0) and np.allclose(
        [found[3].weight + found[4].weight, found[5].weight + found[6].weight], 1.0
    )


def test_an_effect_of_one_run_alone_has_another_amplitude_there() -> None:
    logs = [run_of(0, PUSHED), run_of(1, PUSHED), run_of(2, {"axis.bias_torque": {"T": 0.08}})]
    found = amplitudes(searched(logs, BIAS).fits, BIAS, NOTHING)
    assert found[0].value < 0.6 and found[2].value > 1.1


@pytest.mark.slow
def test_halves_are_those_of_whole_runs_where_runs_are_followed_in_segments() -> None:
    late = Hypothesis(("axis.bias_torque",))
    pushed, free = run_of(0, PUSHED), run_of(0, {})
    changed = {"yaw_rad": np.where(TIME < 4.0, free.outputs["yaw_rad"], pushed.outputs["yaw_rad"])}
    logs = cut_up(with_segments(RIG, [replace(pushed, outputs=changed)], 2.0))
    assert len(logs) == 4
    found = amplitudes(searched(logs, late).fits, late, NOTHING)
    assert found[-2].value < 0.7 < 0.9 < found[-1].value


def test_unevenness_weighs_each_part_and_allows_for_its_error() -> None:
    runs = [Amplitude(1.3, 0.0, 0.25, 0), Amplitude(0.9, 0.0, 0.75, 1)]
    assert np.isclose(unevenness(runs), np.sqrt(0.25 * 0.3**2 + 0.75 * 0.1**2))
    assert unevenness([a._replace(error=0.31) for a in runs]) == 0.0  # chance
    halves = [Amplitude(1.0 + d, 0.0, w, None) for d, w in ((0.5, 0.5), (-0.5, 0.5), (0.5, 0.5), (-0.5, 0.5))]
    assert np.isclose(unevenness([*runs, *halves]), 0.5) and unevenness([]) == 0.0
    assert unevenness([*runs, Amplitude(np.nan, 0.1, 0.1, 2)]) == unevenness([runs[0]._replace(error=np.inf)]) == np.inf
