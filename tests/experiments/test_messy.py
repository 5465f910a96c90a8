"""Rigs with small causes: what a case holds, sizes found otherwise, and how answers to them are judged."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.blind import campaign, changed, draw, messy, score
from experiments.blind.cases import JITTER, make_case, prepare, settled, split, write_case
from experiments.blind.draws import put
from experiments.blind.inseparable import questions
from experiments.blind.oracle import Run, fit, floor, refit
from experiments.blind.rigs import number
from experiments.blind.sensors import coloured, readings
from experiments.blind.simulator import STEP
from experiments.blind.sizes import COARSE
from experiments.blind.tangent import tangent
from rwjax import read_logs, read_rig

KIND, EFFECT, SEED = "wheel", "drive.lag", 3
AMPLITUDE = {EFFECT: 0.5}
Row = dict


@pytest.fixture(scope="module")
def row() -> Row:
    parts = messy.small_parts(KIND, EFFECT, SEED, AMPLITUDE)
    return {"kind": KIND, "effect": EFFECT, "seed": SEED, "amplitude": AMPLITUDE} | parts


def drawn_lines(group: str) -> list[Row]:
    return [line for line in draw.cases("messy") if line["group"] == group]


@pytest.mark.slow
def test_what_is_small_is_reproducible_and_within_its_range(row: Row) -> None:
    assert messy.small_parts(KIND, EFFECT, SEED, AMPLITUDE) == {k: row[k] for k in ("small", "mess", "mess_size")}
    causes = {name: one for name, one in row["small"].items() if not name.startswith("parameter.")}
    assert 3 <= len(causes) <= 6 and EFFECT not in causes
    assert all(0.3 <= one["size"] <= 3.0 and one["amplitude"] <= 1.0 for one in causes.values())
    assert all(one["size"] <= 3.0 for one in row["small"].values())
    assert 1e-4 <= row["mess"]["jitter"] <= 5e-4


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "effect", "seed"), [(KIND, EFFECT, SEED), ("platform", "none", 64)])
def test_a_refit_in_finer_steps_finds_the_sizes(kind: str, effect: str, seed: int, row: Row) -> None:
    small = row["small"] if effect == EFFECT else messy.small_parts(kind, effect, seed, {})["small"]
    prepared = prepare(kind, effect, seed)
    rig, noise = prepared.rig, floor(prepared)
    names = [name for name in small if not name.startswith("parameter.")]
    for name in names:
        truth = put(rig.truth, messy.drawn(prepared, seed, name), small[name]["amplitude"])
        runs = []
        for record, validate in prepared.runs.values():
            record = replace(record, start=settled(truth, record.start))
            runs.append(Run(record, readings(truth, record, noise, STEP), validate))
        if not any(run.validate for run in runs):
            runs[-1] = replace(runs[-1], validate=True)
        gap = fit(rig.truth, list(rig.free), runs, prepared, step=STEP).gap
        found = max(gap[c] / noise[c] for c in noise)
        assert found == pytest.approx(small[name]["size"], rel=0.25), name
        assert 0.25 < found < 3.6, name


def test_a_case_holds_every_cause_and_what_varies(row: Row) -> None:
    case, plain = messy.case_of(row), make_case(KIND, EFFECT, SEED, AMPLITUDE, raw=False)
    assert case == messy.case_of(row)
    assert case.truth["effects"] == [EFFECT] and case.truth["small"] == row["small"]
    assert {*case.truth["changed"]} == {EFFECT, *(n for n in row["small"] if not n.startswith("parameter."))}
    for name, one in row["small"].items():
        if name.startswith("parameter."):
            value, right = case.truth["wrong_numbers"][name.removeprefix("parameter.")], number_of(name)
            assert 0.019 < abs(np.log(value / right)) < 0.1
        else:
            numbers = messy.drawn(prepare(KIND, EFFECT, SEED), SEED, name)
            expected = put(prepare(KIND, EFFECT, SEED).rig.truth, numbers, one["amplitude"])
            assert all(case.truth["parameters"][field] == getattr(expected, field) for field in numbers), name
    factors = list(case.truth["mess"]["friction_of_runs"].values())
    assert len({*factors}) == len(case.logs) and all(0.8 < f < 1.2 for f in factors)
    assert list(case.logs) == list(plain.logs)
    for name, text in case.logs.items():  # times and commands are those of the rig without any mess
        given, before = ([line.split(",")[:2] for line in x.splitlines()] for x in (text, plain.logs[name]))
        assert given == before and text != plain.logs[name]


def number_of(name: str) -> float:
    return number(prepare(KIND, EFFECT, SEED).rig.truth, name.removeprefix("parameter."))


def test_what_varies_is_in_the_runs(row: Row) -> None:
    prepared, mess = prepare(KIND, EFFECT, SEED), messy.Mess(jitter=4e-4, colour=0.9, torque=1e-4, friction=0.03)
    shaken = messy.messed(prepared, SEED, row["small"], mess)
    assert shaken.rig.sensors.colour == 0.9
    for name, (record, validate) in shaken.runs.items():
        before, marked = prepared.runs[name]
        late = record.at - record.time
        assert validate == marked and record.rumble == 1e-4 and record.friction != before.friction
        assert np.all(np.diff(record.at) >= 0.0)
        assert JITTER < np.max(np.abs(late)) < 6e-4
    near = tangent(prepared)
    for shaking in ({"rumble": 1e-4}, {"friction": 1.05}):
        other = [replace(record, **shaking) for record in near.records]
        assert near.size(near.truth, other) > 0.05 or "friction" in shaking  # the same on every run: the fit follows
    assert near.size(near.truth) < 1e-9


def test_coloured_noise_is_as_large_as_white_noise_and_its_neighbours_correlate() -> None:
    noise = coloured(40_000, 0.8, np.random.default_rng(1))
    assert np.std(noise) == pytest.approx(1.0, abs=0.03)
    assert np.corrcoef(noise[1:], noise[:-1])[0, 1] == pytest.approx(0.8, abs=0.02)
    white = np.random.default_rng(1).standard_normal(50)
    assert np.array_equal(coloured(50, 0.0, np.random.default_rng(1)), white)


@pytest.mark.parametrize("group", ["messy", "small"])
def test_the_set_for_development_holds_what_it_says(group: str) -> None:
    lines, places = drawn_lines(group), draw.places("messy")
    assert lines
    for line in lines:
        assert places[line["index"]].effect == line["effect"]
        names = split(line["effect"])
        assert len(names) in ((1, 2) if group == "messy" else (0,))
        assert {*line["amplitude"]} == {*line["sizes"]} == {*names}
        assert all(3.0 <= size <= 30.0 for size in line["sizes"].values())
        assert not {*names} & {*line["small"]}
        assert group == "small" or line["size"] >= 3.0


def test_the_library_reads_a_case_of_the_set(tmp_path: Path) -> None:
    line = drawn_lines("small")[0]
    write_case(messy.case_of(line), tmp_path)
    rig = read_rig(tmp_path / "rig.toml")
    assert len(read_logs(sorted(tmp_path.glob("*.csv")), rig)) >= 4


def test_the_final_set_has_seeds_of_its_own_and_what_was_planned() -> None:
    count = {group: sum(p.group == group for p in draw.places("final")) for group in draw.GROUPS}
    assert (count["messy"], count["none"], count["small"], count["outside"]) == (200, 200, 200, 200)
    assert count["single"] >= 400 and count["pair"] >= 200


A, B, S, T, F = "axis.stribeck", "drive.lag", "axis.spring", "axis.bias_torque", "wheel.drag"
SAME = {T: ["drive.bias"]}


def answer(verdict: str, *options: list[str], effect: str = f"{A}+{B}", group: str = "messy", **more: object) -> Row:
    line = {"index": 0, "group": group, "kind": "reaction", "effect": effect, "seed": 0, "amplitude": {}}
    line |= {"small": {S: {}, T: {}}, "same_as": SAME, "verdict": verdict, "seconds": 1.0}
    line |= {"effects": options[0] if options else [], "alternatives": list(options[1:]), "top": []}
    return line | {"before": 5.0, "after": 1.0, "floor": 1.0, "size": 9.0} | more


JUDGED = [
    ("named", answer("effect", [A, B])),
    ("named", answer("partial", [B, S, A])),
    ("named", answer("ambiguous", [A, B, T], [A, B, "drive.bias"])),
    ("named", answer("effect", [A], effect=A)),
    ("part", answer("partial", [A])),
    ("part", answer("effect", [S])),
    ("part", answer("ambiguous", [A, B], [A, S])),
    ("wider", answer("ambiguous", [A, B], [A, F])),
    ("false", answer("effect", [A, B, F])),
    ("false", answer("partial", [F])),
    ("unknown", answer("unknown", [A])),
    ("none", answer("none")),
    ("error", {k: v for k, v in answer("").items() if k != "verdict"} | {"error": "ValueError"}),
]
ALONE = [
    ("none", answer("none", effect="none", group="small")),
    ("named", answer("effect", [S], effect="none", group="small")),
    ("named", answer("ambiguous", ["drive.bias"], [T], effect="none", group="small")),
    ("false", answer("effect", [A], effect="none", group="small")),
    ("unknown", answer("unknown", effect="none", group="small")),
]


@pytest.mark.parametrize(("judgement", "line"), [*JUDGED, *ALONE])
def test_an_answer_is_judged_by_all_that_is_true(judgement: str, line: Row) -> None:
    assert score.among_small(line) == judgement


def test_the_oracle_is_asked_of_small_cases_about_what_is_not_true_alone() -> None:
    assert questions(answer("ambiguous", [A], [F], [S], effect=A)) == [frozenset([F])]
    assert questions(answer("partial", [A, S], [A, F], [A, F, S], [A, B, F])) == [
        frozenset([A, F]),
        frozenset([A, F, S]),
    ]
    assert questions(answer("effect", [F], effect="none", group="small")) == []


def test_a_refit_with_the_small_causes_begins_nearer_than_one_without() -> None:
    line = drawn_lines("messy")[0]
    case, large = messy.case_of(line), split(line["effect"])
    prepared = messy.prepared_of(line)
    whole, alone = (
        refit(case, "+".join(names), evaluations=2, step=COARSE, prepared=prepared)
        for names in ([*large, *line["small"]], large)
    )
    assert whole.misfit < 0.8 * alone.misfit


def test_tables_of_messy_and_small_cases() -> None:
    large = {row[0]: row[1:] for row in score.messy("Messy", [line for _, line in JUDGED]).rows}
    small = {row[0]: row[1:] for row in score.messy("Small", [line for _, line in ALONE]).rows}
    # 4 of 13 are named, 2 false, 2 say nothing; of small causes alone none and the two names are right
    shares = ["30.8 % (9.1 to 61.4)", "15.4 % (1.9 to 45.4)", "15.4 % (1.9 to 45.4)"]
    assert large["all"] == ["13", *shares, *"4312111"]
    assert large["1 large"][:2] == ["1", "100.0 % (2.5 to 100.0)"] and large["2 large"][1].startswith("25.0 %")
    assert small["all"][:4] == ["5", "60.0 % (14.7 to 94.7)", "20.0 % (0.5 to 71.6)", "20.0 % (0.5 to 71.6)"]


def test_right_is_right_where_answers_are_compared() -> None:
    assert changed.judgement(JUDGED[0][1], {}) == changed.judgement(ALONE[0][1], {}) == "right"
    assert changed.judgement(ALONE[3][1], {}) == "false" and changed.judgement(answer("none"), {}) == "none"


def test_a_campaign_keeps_what_a_score_needs(row: Row, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> None:
        raise ValueError("not asked here")

    monkeypatch.setattr(campaign, "diagnose", refused)
    line = campaign.answer(row | {"set": "messy", "index": 7, "group": "messy", "sizes": {EFFECT: 9.0}})
    assert line["error"].startswith("ValueError") and line["small"] == row["small"] and line["mess"] == row["mess"]
    assert score.among_small(line) == "error"
