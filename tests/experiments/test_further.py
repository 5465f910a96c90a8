"""One more run of a case's rig: the same as the simulator's own by the same command, and nothing else of the case is touched."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.blind.cases import TRAINING
from experiments.blind.commands import TICK, command
from experiments.blind.draw import cases
from experiments.blind.further import recorded, with_command, with_run
from experiments.blind.messy import case_from, case_of, prepared_of

EFFECTS = {
    "wheel": "drive.lag",
    "platform": "axis.stribeck+drive.delay",
    "reaction": "parameter.axis.inertia",
}
VOLTS = command("square", 3.0, 2.0, np.random.default_rng(0))


def row_of(kind: str) -> dict:
    return {"kind": kind, "effect": EFFECTS[kind], "seed": 5, "amplitude": 0.7}


@pytest.mark.parametrize("kind", EFFECTS)
def test_a_further_run_by_a_cases_own_command_is_the_cases_own_run(kind: str) -> None:
    row = row_of(kind)
    own, prepared = case_of(row), prepared_of(row)
    name, (record, validate) = next(iter(prepared.runs.items()))
    alone = case_from(with_run(replace(prepared, runs={}), "next.csv", record, validate), row)  # the first noise drawn
    assert alone.logs["next.csv"] == own.logs[name]


@pytest.mark.parametrize("kind", EFFECTS)
def test_a_further_run_leaves_the_cases_own_files_alone(kind: str) -> None:
    row = row_of(kind)
    own, more = case_of(row), with_command(row, "next.csv", VOLTS)
    assert more.rig == own.rig and list(more.logs) == [*own.logs, "next.csv"]
    assert {name: more.logs[name] for name in own.logs} == own.logs
    assert more.truth["parameters"] == own.truth["parameters"] and more.truth["floor"] == own.truth["floor"]
    head, *values = more.logs["next.csv"].splitlines()
    assert head in own.logs[next(iter(own.logs))].splitlines()[:2]
    table = np.array([[float(cell) for cell in line.split(",")] for line in values])
    assert np.allclose(table[:, 0], np.arange(len(VOLTS)) * TICK, atol=1e-9) and np.allclose(table[:, 1], VOLTS)
    assert more == with_command(row, "next.csv", VOLTS)


def test_two_commands_of_one_length_differ_in_nothing_else() -> None:
    row = row_of("platform")
    prepared = prepared_of(row)
    one, other = (recorded(prepared, row, volts) for volts in (VOLTS, -VOLTS))
    assert np.array_equal(one.at, other.at) and np.array_equal(one.start, other.start) and one.salt == other.salt
    assert one.salt == len(prepared.runs)
    logs = [with_command(row, "next.csv", volts).logs["next.csv"] for volts in (VOLTS, VOLTS * (np.arange(300) < 250))]
    same = [a == b for a, b in zip(*(log.splitlines() for log in logs), strict=True)]
    assert all(same[:250]) and not all(same)  # the same start and noise until the commands part


def test_a_messy_rig_keeps_its_mess_in_a_further_run() -> None:
    row = next(row for row in cases("messy") if row["kind"] == "wheel")
    own, more = case_of(row), with_command(row, "next.csv", VOLTS)
    assert {name: more.logs[name] for name in own.logs} == own.logs
    record = recorded(prepared_of(row), row, VOLTS)
    assert record.rumble == row["mess"]["torque"] and record.friction not in (
        1.0,
        *own.truth["mess"]["friction_of_runs"].values(),
    )


def test_a_name_that_is_taken_is_refused() -> None:
    prepared = prepared_of(row_of("wheel"))
    name, (record, _) = next(iter(prepared.runs.items()))
    assert name.partition("_")[0] in TRAINING
    with pytest.raises(ValueError, match="there is a run of this name"):
        with_run(prepared, name, record)
