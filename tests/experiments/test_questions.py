"""Questions about simulated rigs and published runs: a seeded slice of `experiments.questions.run`."""

from pathlib import Path

import pytest

from experiments.questions.measured import SOURCES, measured
from experiments.questions.run import simulated
from rwjax.fitting.questions.ask import questions


def test_simulated_rigs_that_lack_an_effect_raise_no_question() -> None:
    for what, rig, logs in simulated("explore", 2):
        assert questions(rig, logs) == [], what


@pytest.mark.slow
def test_published_runs_raise_no_question(realdata: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RWJAX_REALDATA", str(realdata))
    tried = {name: questions(rig, logs) for name, rig, logs in measured(tmp_path)}
    assert {"emps", "dcmotor", *SOURCES} == set(tried)
    assert {name: asked for name, asked in tried.items() if asked} == {}
