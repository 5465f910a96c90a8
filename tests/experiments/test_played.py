"""The next experiment against random ones: the random command, which cases are asked, and scores by hand-made lines."""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.blind.cases import Case
from experiments.blind.draw import cases, read
from experiments.blind.messy import case_of
from experiments.played import run as campaign
from experiments.played.rival import FAMILIES, random_command
from experiments.played.score import after, left_open, outcome, ratio, state, tables
from rwjax.planning.designs import DESIGNS
from rwjax.planning.experiment import Experiment

SAID = {"named": [["drive.lag"]], "open": [["drive.delay"], ["drive.lag"]], "wrong": [["drive.delay"]]}
ROW = next(row for row in cases("fourth") if row["kind"] == "wheel" and row["group"] == "single")


def answer(*options: list[str], verdict: str = "") -> dict:
    verdict = verdict or ("ambiguous" if len(options) > 1 else "effect" if options else "unknown")
    return {"verdict": verdict, "effects": options[0] if options else [], "alternatives": list(options[1:])}


def line(before: str, proposed: str | None = None, random: str | None = None, **more: object) -> dict:
    made = {"effect": "drive.lag", "same_as": {}, "group": "single", "proposal": "run a square", "seconds": 3.0}
    said = {"before": before, "proposed": proposed, "random": random}
    return made | {run: name and answer(*SAID[name]) for run, name in said.items()} | more


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("pace", [1.0, 0.25])
def test_a_random_command_has_length_and_limit_of_the_proposed_one(design: str, pace: float) -> None:
    _, volts = DESIGNS[design].at(3.217, pace).command()
    seen = set()
    for seed in range(12):
        family, other = random_command(volts, seed)
        again = random_command(volts, seed)
        assert again[0] == family and np.array_equal(again[1], other)
        assert len(other) == len(volts) and np.max(np.abs(other)) == pytest.approx(np.max(np.abs(volts)), abs=5.1e-4)
        assert np.all(other[:52] == 0.0) and family in FAMILIES
        seen.add(family)
    assert len(seen) > 3


def test_a_command_that_is_nothing_has_no_rival() -> None:
    with pytest.raises(ValueError, match="0 throughout"):
        random_command(np.zeros(300), 1)


def test_outcomes_of_an_answer() -> None:
    one = line("open")
    assert [outcome(answer(*said), one) for said in SAID.values()] == [*SAID]
    assert outcome(answer(), one) == "unknown" and outcome({"error": "none"}, one) == "error"
    assert outcome(answer(["drive.lag", "axis.spring"]), one) == "wrong"
    same = one | {"same_as": {"drive.lag": ["drive.delay"]}}
    assert outcome(answer(*SAID["open"]), same) == "named" and not left_open(answer(*SAID["open"]), same)
    pair = one | {"effect": "drive.lag+axis.spring"}
    assert outcome(answer(["drive.lag"], verdict="partial"), pair) == "part"
    assert outcome(answer(["axis.spring", "drive.lag"]), pair) == "named"


def test_what_became_of_a_case() -> None:
    assert state(line("open", "named", "open")) == "played"
    assert state(line("named")) == "closed"
    assert (
        state(line("open", proposal="none can tell them apart: for this kind of rig they are the same thing")) == "same"
    )
    for said in (
        "no command within 2.6 V separates a and b: there they are the same thing for this rig",
        "none found that separates a",
    ):
        assert state(line("open", proposal=said)) == "no command"
    assert state(line("open", proposal="one motor at a time")) == "no plan"
    assert state(line("open") | {"before": {"error": "it broke"}}) == "error"


def test_the_tables_count_what_was_played() -> None:
    lines = [line("open", "named", "open"), line("open", "named", "open"), line("open", "open", "open")]
    lines += [line("open", "wrong", "named"), line("named"), line("open", proposal="none")]
    found, then, against, took = tables(lines)
    assert {name: count for _, name, count in found.rows} == {
        "played": "4",
        "closed": "1",
        "same": "0",
        "no command": "0",
        "no plan": "1",
        "error": "0",
    }
    proposed, random = then.rows
    assert proposed[:2] == ["proposed", "4"] and proposed[2].startswith("25.0 %") and random[2].startswith("75.0 %")
    assert proposed[5:9] == ["2", "1", "0", "1"] and random[5:9] == ["1", "3", "0", "0"]
    assert [count for _, count in against.rows[:4]] == ["1", "0", "2", "1"] and against.rows[4][1].startswith("0.33 (")
    assert took.rows == [["3", "3", "3"]]
    assert after([])[2][0][1] == "0"


def test_the_ratio_has_an_interval_that_holds_it() -> None:
    said = ratio([True] * 10 + [False] * 30, [True] * 20 + [False] * 20)
    low, high = (float(word) for word in said[said.index("(") + 1 : -1].split(" to "))
    assert said.startswith("0.50 (") and 0.2 < low < 0.5 < high < 0.8
    assert ratio([True], [False]) == "–"


def test_only_cases_that_are_left_open_are_asked() -> None:
    rows = campaign.wanted("fourth", read(campaign.RESULTS / "fourth.jsonl"))
    stored = {one["index"]: one for one in read(campaign.RESULTS / "fourth.jsonl")}
    assert rows and all(stored[row["index"]]["verdict"] == "ambiguous" for row in rows)
    assert {row["group"] for row in rows} <= {"single", "pair"}
    assert len(campaign.wanted("fourth", [])) > len(rows)


def test_a_case_is_played_twice_where_it_is_open_and_a_run_is_proposed(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Case] = []
    experiment = DESIGNS["square"].at(2.0)
    true, rival = [ROW["effect"]], ["axis.spring"]

    def found(_: object, logs: list) -> SimpleNamespace:
        said = answer(true, rival) if len(asked) == 1 else answer(true)
        plan = SimpleNamespace(runs=[SimpleNamespace(experiment=experiment)])
        return SimpleNamespace(json=lambda: said, next_experiment="run a square", proposal=plan)

    def kept(case: Case, folder: object) -> None:
        asked.append(case)

    monkeypatch.setattr(campaign, "write_case", kept)
    monkeypatch.setattr(campaign, "read_rig", lambda path: None)
    monkeypatch.setattr(campaign, "read_logs", lambda paths, rig: [])
    monkeypatch.setattr(campaign, "diagnose", found)
    monkeypatch.setattr(campaign, "commit", lambda: "abc1234")
    one = campaign.played(ROW)
    own = case_of(ROW)
    assert [len(case.logs) - len(own.logs) for case in asked] == [0, 1, 1]
    assert [one[run]["outcome"] for run in ("before", "proposed", "random")] == ["open", "named", "named"]
    assert Experiment(**one["experiment"]) == experiment and one["commit"] == "abc1234"
    written = [[float(row.split(",")[1]) for row in case.logs[campaign.LOG].splitlines()[1:]] for case in asked[1:]]
    assert np.allclose(written[0], experiment.command()[1], atol=5e-4)
    assert len(written[1]) == len(written[0]) and np.max(np.abs(written[1])) == pytest.approx(
        np.max(np.abs(written[0]))
    )
    assert written[1] != written[0]
