"""The held-out rule: no sample is ever on both sides, and a marked log is never trained on."""

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.logs.held_out import folds
from rwjax.logs.log import Log


def log(name: str, validate: bool = False, n: int = 60) -> Log:
    t = 5.0 + 0.1 * np.arange(n)
    outputs = {"yaw_rad": np.sin(t)}
    return Log(name, t, np.cos(t), outputs, {"yaw_rad": 0.0}, {}, validate, None, origin=5.0)


def names(logs: tuple[Log, ...]) -> list[str]:
    return [log.name for log in logs]


@pytest.mark.parametrize(
    ("marks", "rule", "split"),
    [
        ("tv", "marked", [("a", "b")]),
        ("vtv", "marked", [("b", "ac")]),
        ("tttv", "marked", [("abc", "d")]),
        ("tt", "each-on-the-other", [("b", "a"), ("a", "b")]),
        ("ttt", "leave-one-run-out", [("bc", "a"), ("ac", "b"), ("ab", "c")]),
    ],
)
def test_whole_logs_are_held_out(marks, rule, split):
    found, splits = folds([log(name, mark == "v") for name, mark in zip("abcd", marks, strict=False)])
    assert found == rule
    assert [("".join(names(f.train)), "".join(names(f.test))) for f in splits] == split


def test_one_log_holds_out_its_last_third():
    run = log("square.csv", n=61)
    rule, (fold,) = folds([run])
    (train,), (test,) = fold.train, fold.test
    assert rule == "last-third" and len(test.time) == 20
    assert np.array_equal(np.concatenate([train.time, test.time]), run.time)
    assert train.origin == test.origin == 5.0  # time-dependent effects count from the start of the run
    assert (train.name, test.name) == ("square.csv[…9.0 s]", "square.csv[9.1 s…]")


@pytest.mark.parametrize(
    ("logs", "message"),
    [
        (
            [log("a.csv", True), log("b.csv", True)],
            "a.csv, b.csv: no log to fit on; give at least one without `# role",
        ),
        ([], "no log: no log to fit on"),
        ([log("a.csv", n=29)], "a.csv: 29 samples; a single log needs at least 30, or give a second log"),
    ],
)
def test_logs_that_cannot_be_split(logs, message):
    with pytest.raises(LogError) as error:
        folds(logs)
    assert message in str(error.value)


@pytest.mark.parametrize("n", [30, 31, 32])
def test_the_shortest_log_that_can_be_split_keeps_enough_for_both(n: int) -> None:
    _, (fold,) = folds([log("a.csv", n=n)])
    assert (len(fold.train[0].time), len(fold.test[0].time)) == (n - 10, 10)


def test_a_signal_that_stops_early_cannot_be_judged():
    run = log("a.csv")
    run.outputs["yaw_rad"][30:] = np.nan
    with pytest.raises(LogError, match=r"a.csv\[9.0 s…\]: no reading of `yaw_rad`; give a second log"):
        folds([run])
