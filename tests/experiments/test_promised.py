"""Fresh runs of a blind case: its own logs stay what they are, and every fresh run is a log of its own."""

from experiments.blind.draw import cases, read
from experiments.blind.messy import case_of
from experiments.promised import RESULTS, fresh_names, wanted, with_fresh_runs


def test_fresh_runs_leave_the_case_as_it_is_and_differ_from_each_other() -> None:
    row = next(row for row in cases("fourth") if row["group"] == "single")
    own, more = case_of(row), with_fresh_runs(row, 3)
    assert more.rig == own.rig and {name: more.logs[name] for name in own.logs} == own.logs
    fresh = [more.logs[name] for name in fresh_names(3)]
    assert len({*fresh}) == 3 and {*more.logs} == {*own.logs, *fresh_names(3)}
    assert not any("role: validate" in text for text in fresh)


def test_the_cases_promise_something_by_all_true_names() -> None:
    stored = {line["index"]: line for line in read(RESULTS / "fourth.jsonl")}
    asked = [stored[row["index"]] for row in wanted("fourth")]
    assert len(asked) == 28 and all(
        line["ci95"] and {*line["effects"]} == {*line["effect"].split("+")} for line in asked
    )
