"""Readings and commands in another unit or of the other sign are asked about, right ones are not."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.questions.likeness import Run
from rwjax.fitting.questions.readings import about_readings
from rwjax.logs.log import Log
from rwjax.rig.columns_section import sources
from tests.systems import platform, record, run

TIME = np.arange(600) * 0.01
COMMAND = np.where(TIME < 0.6, 0.0, 4.0 * np.sin(2.0 * TIME))
YAW = run(platform(), record(TIME, COMMAND), {})["yaw_rad"]


def log(factor: float) -> Log:
    """A run with its readings multiplied, counted to a thousandth of a turn."""
    return record(TIME, COMMAND, {"yaw_rad": factor * np.round(YAW * 1000.0) / 1000.0})


@pytest.mark.parametrize(
    ("factor", "says"),
    [
        (-1.0, "is its sign, or that of the command, wrong? Write sign = -1 for the wrong one in [columns]"),
        (180.0 / np.pi, 'in degrees? Write unit = "deg" in [columns], or divide them by 57.296'),
        (2048 / (2.0 * np.pi), "are the readings counts, about 1.7e+03 to a turn? Their column is called yaw_counts"),
        (1e-3, "is the command in mV?"),
    ],
)
def test_one_question_is_asked(factor: float, says: str) -> None:
    (question,) = about_readings([Run(log(factor), {"yaw_rad": 1.2 * YAW})])
    assert says in question


@pytest.mark.parametrize(
    ("name", "factor", "words"),
    [("yaw_rad_s", 30.0 / np.pi, "rpm"), ("yaw_rad_s", 180.0 / np.pi, "deg/s"), ("current_A", 1e3, "mA")],
)
def test_a_question_names_a_unit_that_columns_take(name: str, factor: float, words: str) -> None:
    (question,) = about_readings([Run(record(TIME, COMMAND, {name: factor * YAW}), {name: YAW})])
    assert f'Write unit = "{words}" in [columns]' in question
    assert sources({f"{name}.column": "x", f"{name}.unit": words}, "reaction")[name].factor == pytest.approx(
        1.0 / factor
    )


def counted(factor: float) -> Log:
    return replace(log(factor), resolution={"yaw_rad": 2.0 * np.pi / 1000.0})


@pytest.mark.parametrize(("factor", "do"), [(4.0, "times 4"), (0.25, "divided by 4")])
def test_counts_of_lines_are_asked_about_and_readings_in_rad_are_not(factor: float, do: str) -> None:
    (question,) = about_readings([Run(counted(factor), {"yaw_rad": 1.2 * YAW})])
    assert f"should its encoder's counts_per_rev be {do}?" in question
    assert about_readings([Run(log(factor), {"yaw_rad": 1.2 * YAW})]) == []


@pytest.mark.parametrize("given", [log, counted])
@pytest.mark.parametrize("factor", [1.0, 0.7, 1.4, 8.0, 0.05])
def test_numbers_that_are_off_besides_ask_nothing(factor: float, given: Callable[[float], Log]) -> None:
    assert about_readings([Run(given(factor), {"yaw_rad": YAW})]) == []


def test_a_reading_that_stands_still_while_the_command_moves_is_asked_about() -> None:
    still = record(TIME, COMMAND, {"yaw_rad": np.full(len(TIME), 0.3)})
    (question,) = about_readings([Run(still, {"yaw_rad": YAW})])
    assert question.startswith("test.csv: yaw_rad stays the same")
    noisy = record(TIME, COMMAND, {"yaw_rad": 0.01 * np.random.default_rng(5).normal(size=len(TIME))})
    assert len(about_readings([Run(noisy, {"yaw_rad": YAW})])) == 1
    stuck = {"yaw_rad": 1e-3 * YAW}
    assert about_readings([Run(still, stuck)]) == []  # the simulated rig hardly moves either
    assert about_readings([Run(replace(still, command=np.full(len(TIME), 2.0)), {"yaw_rad": YAW})]) == []
    within_a_count = replace(counted(1.0), outputs={"yaw_rad": np.where(TIME < 1.0, 0.0, 2.0 * np.pi / 1000.0)})
    assert len(about_readings([Run(within_a_count, {"yaw_rad": YAW})])) == 1


def test_a_rig_that_sticks_in_one_run_is_not_asked_about_and_a_dead_sensor_is() -> None:
    noise = 1e-3 * np.random.default_rng(5).normal(size=len(TIME))
    moves = Run(record(TIME, COMMAND, {"yaw_rad": YAW + noise}), {"yaw_rad": YAW})
    sticks = Run(record(TIME, COMMAND, {"yaw_rad": 0.3 + noise}), {"yaw_rad": YAW})
    dead = Run(record(TIME, COMMAND, {"yaw_rad": np.full(len(TIME), 0.3)}), {"yaw_rad": YAW})
    counts = Run(replace(dead.log, resolution={"yaw_rad": 1e-3}), {"yaw_rad": YAW})
    assert about_readings([moves, sticks]) == []
    assert about_readings([moves, counts]) == []  # a counter at rest is as constant as a dead one
    assert len(about_readings([moves, dead])) == len(about_readings([sticks])) == 1


def test_dry_friction_that_leaves_a_quarter_of_some_motions_is_no_question_of_edges() -> None:
    runs = [Run(counted(factor), {"yaw_rad": YAW}) for factor in (0.17, 0.27, 0.5)]
    assert about_readings(runs) == []


def test_what_already_is_counts_is_not_said_to_be_counts() -> None:
    (question,) = about_readings([Run(counted(120.0), {"yaw_rad": YAW})])
    assert "is its encoder's counts_per_rev right, and the unit of the command?" in question
    assert "called yaw_counts" not in question
