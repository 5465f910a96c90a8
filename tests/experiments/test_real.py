"""Measured rigs with a withheld label: the manifest, what is published of the rigs, and what an answer is worth."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.real.fair import can_be_named, is_fair, left, left_of_fitted, left_of_others, put_right
from experiments.real.pairs import Pair, given, own, pairs, with_friction_free
from experiments.real.published import PUBLISHED, Published
from experiments.real.run import outcome
from experiments.real.setups import SETS
from rwjax.diagnosis.hypothesis import candidates
from rwjax.effects.library import BY_NAME
from rwjax.logs.driven import driven_by
from rwjax.logs.log import Log
from rwjax.rig.model import Rig
from tests.systems import platform, record, run

LOAD = ("parameter.axis.inertia", "parameter.axis.gravity.torque")


@pytest.mark.parametrize(
    ("verdict", "sets", "worth"),
    [
        ("effect", [LOAD], "named"),
        ("effect", [LOAD[::-1]], "named"),
        ("ambiguous", [("axis.spring",), ("parameter.motor.inertia", LOAD[1])], "named with others"),
        ("ambiguous", [LOAD, ("parameter.motor.inertia", LOAD[1])], "named"),
        ("effect", [("parameter.axis.inertia", "parameter.motor.inertia")], "wrong"),
        ("partial", [LOAD[:1]], "in part"),
        ("effect", [(*LOAD, "axis.stribeck")], "beside published"),
        ("effect", [("axis.spring",), (LOAD[1], "axis.stribeck")], "beside published"),
        ("effect", [(*LOAD, "axis.spring")], "wrong"),
        ("effect", [("axis.stribeck",)], "wrong"),
        ("unknown", [LOAD], "unknown"),
        ("none", [()], "none"),
    ],
)
def test_what_an_answer_is_worth(verdict: str, sets: list[tuple[str, ...]], worth: str) -> None:
    assert outcome(verdict, sets, list(LOAD), ["axis.stribeck"]) == worth


@pytest.mark.parametrize(
    ("verdict", "sets", "worth"),
    [
        ("none", [()], "nothing"),
        ("unknown", [("axis.spring",)], "nothing"),
        ("partial", [("axis.backlash",)], "published"),
        ("ambiguous", [("axis.spring",), ("axis.backlash",)], "published"),
        ("partial", [("axis.backlash", "axis.spring")], "wrong"),
        ("effect", [("parameter.axis.inertia",)], "wrong"),
    ],
)
def test_what_an_answer_is_worth_where_nothing_was_changed(
    verdict: str, sets: list[tuple[str, ...]], worth: str
) -> None:
    assert outcome(verdict, sets, [], ["axis.backlash", "axis.stribeck"]) == worth


@pytest.mark.parametrize(
    ("changed", "of_own", "of_given", "fair"),
    [
        (True, 0.01, 0.03, True),
        (True, 0.01, 0.02, False),
        (True, 0.01, float("inf"), True),
        (True, float("inf"), float("inf"), False),
        (False, 0.01, 0.03, True),
        (False, 0.01, 0.04, False),
    ],
)
def test_a_fair_question(changed: bool, of_own: float, of_given: float, fair: bool) -> None:
    assert is_fair(changed, of_own, of_given) == fair


def test_what_can_be_named() -> None:
    assert can_be_named(0.1, 0.04) is True and can_be_named(0.1, 0.08) is False and can_be_named(0.1, None) is None


def test_what_is_put_right() -> None:
    pair = Pair("frozen", "a", "first", "second", list(LOAD))
    right = put_right(pair)
    assert right is not None and right.told == ("axis.inertia", "axis.gravity.torque") and not right.changed
    assert put_right(pair._replace(changed=[])) is None
    assert put_right(pair._replace(changed=["drive.supply_sag"])) is None
    assert put_right(pair._replace(given_data="b")) is None


def test_pairs_have_names_of_their_own_and_differ_in_something_or_in_their_runs() -> None:
    every = pairs()
    assert len({pair.name for pair in every}) == len(every) >= 40
    assert {pair.set for pair in every} == {"develop", "frozen", "repeated"}
    for pair in every:
        first = pair.data, pair.fitted, pair.fitted_runs
        assert first != (pair.given_data or pair.data, pair.given, pair.given_runs) or pair.withheld, pair.name


@pytest.mark.parametrize("pair", pairs(), ids=lambda pair: pair.name)
def test_what_was_changed_is_among_the_candidates(pair: Pair) -> None:
    rigs = [SETS[pair.data].rig(pair.fitted), SETS[pair.given_data or pair.data].rig(pair.given)]
    assert rigs[0].kind == rigs[1].kind and {*rigs[0].numbers} == {*rigs[1].numbers}
    assert {*pair.changed} <= {*BY_NAME, *(f"parameter.{name}" for name in rigs[0].numbers)}
    assert {*pair.told} <= {*rigs[0].numbers}


@pytest.mark.parametrize("supplied", [True, False])
def test_a_supply_that_drops_is_a_candidate_where_its_voltage_is_withheld(supplied: bool) -> None:
    rig = SETS["bam_xl330_pendulum"].rig("kp400")
    rig = replace(rig, free=(), numbers=rig.numbers | {"drive.supply": 8.3})
    rig = driven_by(rig, "goal_rad", switched=True, supplied=supplied)
    assert ("drive.supply_sag" in candidates(rig)) == (not supplied)


@pytest.mark.parametrize("pair", pairs(), ids=lambda pair: pair.name)
def test_the_logs_of_every_pair_are_there(pair: Pair, realdata: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RWJAX_REALDATA", str(realdata))
    rig = SETS[pair.data].rig(pair.fitted)
    rig, logs = given(pair, rig)
    assert len(own(pair, rig)) >= max(1, len(pair.fitted_runs)) and len(logs) >= max(1, len(pair.given_runs))
    assert not pair.withheld or ("drive.supply" in rig.numbers and all(log.supply is None for log in logs))


def test_what_is_published_has_names_of_the_library() -> None:
    for data, said in PUBLISHED.items():
        assert said.source and bool(said.reason) != (data in SETS), data
        rig = None if said.reason else SETS[data].rig(said.setup)
        numbers = set() if rig is None else {f"parameter.{name}" for name in rig.numbers}
        assert {*said.present, *said.contradict} <= {*BY_NAME, *numbers}, data
        assert not {*said.present} & {*said.contradict}


def test_every_published_set_is_listed(realdata: Path) -> None:
    assert {path.name for path in realdata.iterdir() if path.is_dir()} == {*PUBLISHED}
    assert {pair.data for pair in pairs()} <= {*PUBLISHED}


@pytest.mark.parametrize(
    ("verdict", "sets", "worth"),
    [
        ("unknown", [("axis.backlash",)], "no claim"),
        ("effect", [("axis.backlash",)], "agrees"),
        ("ambiguous", [("axis.spring",), ("axis.backlash",)], "agrees"),
        ("partial", [("axis.backlash", "axis.spring")], "more"),
        ("partial", [("axis.spring",)], "other"),
        ("effect", [("sensor.scale", "axis.backlash")], "contradicts"),
    ],
)
def test_an_answer_beside_what_is_published(verdict: str, sets: list[tuple[str, ...]], worth: str) -> None:
    said = Published(["axis.backlash"], ["sensor.scale"], "a paper")
    assert said.says(verdict, sets) == worth


@pytest.mark.parametrize(
    ("setup", "numbers"),
    [("L100_m0535", {"drive.servo.kp"}), ("kp32", {"axis.inertia", "axis.gravity.torque"}), ("L100_m0535_kp08", set())],
)
def test_what_differs_from_run_to_run_of_a_set_up_is_known(
    setup: str, numbers: set[str], realdata: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RWJAX_REALDATA", str(realdata))
    rigs = SETS["feetech_sts3250_pendulum"]
    first, logs = rigs.rig(setup), rigs.logs("feetech_sts3250_pendulum", setup, rigs.rig(setup), ())
    assert {name for log in logs for name in log.added} == numbers
    for log in logs:
        own = rigs.rig(f"L{Path(log.name).stem.partition('_L')[2]}").numbers
        for name in numbers:
            assert first.numbers[name] + log.added.get(name, 0.0) == pytest.approx(own[name], rel=1e-12)


NUMBERS_OF = {
    "length_m": ("axis.inertia", "axis.gravity.torque"),
    "mass_kg": ("axis.inertia", "axis.gravity.torque"),
    "kp": ("drive.servo.kp",),
}
"""Numbers of the rig file that go with a column of the lists in which the pendulums' authors say how each run was made."""


@pytest.mark.parametrize("pair", [pair for pair in pairs() if pair.data.endswith("_pendulum")], ids=lambda p: p.name)
def test_what_was_changed_is_what_the_authors_list(pair: Pair, realdata: Path) -> None:
    listed = []
    for data, setup in ((pair.data, pair.fitted), (pair.given_data or pair.data, pair.given)):
        with (realdata / data / "manifest.csv").open() as file:
            listed.append([row for row in csv.DictReader(file) if f"_{setup}_" in row["file"].replace(".csv", "_")])
    assert all(listed)
    differs = {
        name
        for key, names in NUMBERS_OF.items()
        if {row.get(key) for row in listed[0]} != {row.get(key) for row in listed[1]}
        for name in names
    }
    said = {*pair.told, *(name.removeprefix("parameter.") for name in pair.changed)}
    assert differs == ({*()} if pair.given_data else said)


@pytest.mark.parametrize("pair", pairs(), ids=lambda pair: pair.name)
def test_a_friction_that_is_left_free_is_no_candidate_and_was_not_changed_itself(pair: Pair) -> None:
    freed = with_friction_free(pair)
    rig = replace(SETS[pair.data].rig(pair.fitted), free=freed.free)
    assert freed.free or pair.given_data
    assert not {f"parameter.{name}" for name in freed.free} & {*candidates(rig), *pair.changed}


def test_what_a_rig_file_leaves_free_is_estimated_before_it_is_said_what_is_left() -> None:
    t, right = np.arange(300) * 0.01, platform(free="")
    log = record(t, np.sign(np.sin(2.0 * t)))
    log = record(t, log.command, run(right, log, {}))
    wrong = right.with_values({"axis.friction.viscous": 3.0 * right.values["axis.friction.viscous"]})
    assert left_of_fitted(replace(wrong, free=("axis.friction.viscous",)), [log]) < 1e-3 * left_of_fitted(wrong, [log])


@pytest.mark.slow
def test_a_number_that_was_changed_is_put_right_from_the_other_runs() -> None:
    t, right = np.arange(300) * 0.01, platform(free="")

    def follows(rig: Rig, rate: float) -> Log:
        log = record(t, np.sign(np.sin(rate * t)))
        return record(t, log.command, run(rig, log, {}))

    runs, wrong = [follows(right, rate) for rate in (2.0, 3.0)], right.with_values({"axis.inertia": 0.2})
    assert left_of_others(wrong, runs, ["axis.inertia"]) < 1e-3 * left(wrong, runs)
    odd = follows(right.with_values({"axis.inertia": 0.15}), 4.0)  # the others do not tell of it
    missed = np.sqrt(np.mean(np.square([left(right, [odd]), *2 * [0.0]])))
    assert left_of_others(wrong, [*runs, odd], ["axis.inertia"]) > missed
