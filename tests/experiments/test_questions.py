"""Questions about simulated rigs and published runs: a seeded slice of `experiments.questions.run`."""

from pathlib import Path

import pytest

from experiments.questions.measured import SOURCES, measured
from experiments.questions.mislabelled import INPUTS, OUTCOMES, fitted, given, outcome, right_numbers
from experiments.questions.run import simulated
from rwjax.fitting.questions.ask import questions


def test_simulated_rigs_that_lack_an_effect_raise_no_question() -> None:
    for what, rig, logs in simulated("explore", 2):
        assert questions(rig, logs) == [], what


def test_each_mislabelled_input_says_other_than_the_right_one() -> None:
    rigs = {kind: given(kind) for kind in ("platform", "wheel")}
    assert len(INPUTS) == 24
    for what, one in INPUTS.items():
        assert one.change(rigs[one.kind]) != rigs[one.kind], what


@pytest.mark.slow
def test_mislabelled_inputs_are_asked_about_refused_or_read_rightly() -> None:
    files = given("platform")
    right = right_numbers(files)
    for what, expected in (("degrees as rad", "asked"), ("no head", "refused"), ("decimal commas", "right")):
        assert outcome(*fitted(INPUTS[what].change(files)), right)[0] == expected, what


def test_a_fit_with_other_numbers_is_absurd_where_nothing_is_said() -> None:
    answer = '{"numbers": {"axis.inertia": {"value": 2.0}}, "notes": [%s]}'
    assert outcome(0, answer % "", "", {"axis.inertia": 1.0})[0] == "absurd"
    assert outcome(0, answer % '"far above the noise"', "", {"axis.inertia": 1.0})[0] == "doubted"
    assert outcome(0, answer % "", "", {"axis.inertia": 2.01})[0] == "right" and len(OUTCOMES) == 6
    assert outcome(1, "", "Traceback", {})[0] == outcome(2, "", "", {})[0] == "crashed"


@pytest.mark.slow
def test_published_runs_raise_no_question(realdata: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RWJAX_REALDATA", str(realdata))
    tried = {name: questions(rig, logs) for name, rig, logs in measured(tmp_path)}
    assert {"emps", "dcmotor", *SOURCES} == set(tried)
    assert {name: asked for name, asked in tried.items() if asked} == {}
