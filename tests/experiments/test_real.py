"""Measured rigs with a withheld label: the manifest, and what an answer is worth."""

from pathlib import Path

import pytest

from experiments.real.run import RUNS, outcome, pairs, plain_rig
from rwjax import parse_rig

LOAD = ("parameter.axis.inertia", "parameter.axis.gravity.torque")


@pytest.mark.parametrize(
    ("verdict", "sets", "worth"),
    [
        ("effect", [LOAD], "named"),
        ("effect", [LOAD[::-1]], "named"),
        ("ambiguous", [("axis.spring",), ("parameter.motor.inertia", LOAD[1])], "named"),
        ("partial", [LOAD[:1]], "in part"),
        ("effect", [(*LOAD, "axis.stribeck")], "wrong"),
        ("effect", [("axis.stribeck",)], "wrong"),
        ("unknown", [LOAD], "unknown"),
        ("none", [()], "none"),
    ],
)
def test_what_an_answer_is_worth(verdict: str, sets: list[tuple[str, ...]], worth: str) -> None:
    assert outcome(verdict, sets, list(LOAD)) == worth


def test_every_pair_is_of_one_rig_and_a_number_of_it_is_changed() -> None:
    every = pairs()
    assert len({pair.name for pair in every}) == len(every) and {pair.set for pair in every} == {"develop", "frozen"}
    for pair in every:
        assert pair.fitted != pair.given
        given, fitted = (parse_rig(plain_rig(pair.data, setup), "rig.toml") for setup in (pair.given, pair.fitted))
        assert given.kind == fitted.kind == "joint"
        assert all(name.removeprefix("parameter.") in fitted.numbers for name in pair.changed)


def test_the_logs_of_every_pair_are_there(realdata: Path) -> None:
    for pair in pairs():
        for setup in (pair.fitted, pair.given):
            assert sum((realdata / pair.data / f"{run}_{setup}.csv").exists() for run in RUNS) >= 2
