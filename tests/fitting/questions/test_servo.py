"""Servos whose position contradicts its goal or its logged speed are asked about, those that hardly follow are not."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.questions.servo import about_servos
from rwjax.logs.log import Log
from tests.joints import joint, logged, servo

TIME = 0.01 * np.arange(800)
GOAL = np.where(TIME < 3.0, 0.8 * np.sin(2.0 * TIME), np.where(TIME < 5.5, 0.5, -0.7))
DEGREES = 180.0 / np.pi


def measured(goal: np.ndarray = GOAL, kp: float = 8.0, **columns: np.ndarray) -> Log:
    """A servo's run with its speed, as it should be."""
    log = logged(servo(joint(), kp=kp), TIME, goal_rad=goal, **columns)
    log = replace(log, resolution={})
    return replace(log, outputs=log.outputs | {"yaw_rad_s": np.gradient(log.outputs["yaw_rad"], TIME)})


def wrong(log: Log, position: float = 1.0, speed: float = 1.0, goal: float = 1.0) -> Log:
    """A log with its columns multiplied; a speed of 0 times is left out."""
    outputs = {"yaw_rad": position * log.outputs["yaw_rad"], "yaw_rad_s": speed * log.outputs["yaw_rad_s"]}
    kept = {name: y for name, y in outputs.items() if speed or name == "yaw_rad"}
    return replace(log, command=goal * log.command, outputs=kept)


MISTAKES = [
    (
        (DEGREES, 1.0, 1.0),
        "57.3 times as far as goal_rad and yaw_rad_s say: is yaw_rad in degrees, or are goal_rad and yaw_rad_s in radians",
    ),
    (
        (1.0 / DEGREES, 1.0, 1.0),
        "0.0175 times as far as goal_rad and yaw_rad_s say: are goal_rad and yaw_rad_s in degrees, or is yaw_rad in radians",
    ),
    (
        (1.0 / DEGREES, 1.0 / DEGREES, 1.0),
        "0.0175 times as far as goal_rad says: is goal_rad in degrees, or is yaw_rad in radians already?",
    ),
    ((1.0, 1.0, DEGREES), "0.0175 times as far as goal_rad says: is goal_rad in degrees"),
    (
        (1.0, 1.0, 1.0 / DEGREES),
        "57.3 times as far as goal_rad says: is yaw_rad in degrees, or is goal_rad in radians already?",
    ),
    ((1.0, DEGREES, 1.0), "0.0175 times as far as yaw_rad_s says: is yaw_rad_s in degrees"),
    ((DEGREES, 0.0, 1.0), "57.3 times as far as goal_rad says: is yaw_rad in degrees"),
    ((-1.0, 1.0, 1.0), "yaw_rad goes against what goal_rad and yaw_rad_s say: is its sign wrong"),
    ((1.0, -1.0, 1.0), "yaw_rad goes against what yaw_rad_s says: is its sign wrong, or that of yaw_rad_s?"),
    ((-1.0, 0.0, 1.0), "yaw_rad goes against what goal_rad says: is its sign wrong, or that of goal_rad?"),
]


@pytest.mark.parametrize(("factors", "says"), MISTAKES)
def test_a_position_that_contradicts_its_goal_or_its_speed_is_asked_about(
    factors: tuple[float, float, float], says: str
) -> None:
    (question,) = about_servos([wrong(measured(), *factors)])
    assert question.startswith("run.csv: yaw_rad ") and says in question and "in [columns]" in question


def test_several_logs_with_one_mistake_are_one_question() -> None:
    step = np.where(TIME > 1.0, 0.8, 0.0)
    slow = replace(wrong(measured(step, kp=0.05), DEGREES), name="slow.csv")  # told by its speed alone
    (question,) = about_servos([slow, wrong(measured(), DEGREES), measured()])
    assert question.startswith(
        "slow.csv and run.csv: yaw_rad moves about 57.3 times as far as goal_rad and yaw_rad_s say"
    )


STILL = np.full(len(TIME), 0.5)
OFF = np.where(TIME > 0.2, 0.0, 1.0)


@pytest.mark.parametrize(
    "log",
    [
        measured(),
        measured(kp=0.05),
        measured(np.where(TIME > 1.0, 0.8, 0.0), kp=0.05),
        measured(STILL),
        measured(0.003 * np.sin(2.0 * TIME)),
        measured(0.01 * TIME + 1.6, kp=0.3),
        measured(enabled=OFF),
        replace(measured(), input="voltage_V", command=-GOAL),
    ],
    ids=[
        "follows",
        "sluggish",
        "sluggish steps",
        "a goal held",
        "a goal hardly moved",
        "starts far away",
        "torque off",
        "no goal",
    ],
)
def test_a_servo_that_may_be_right_is_not_asked_about(log: Log) -> None:
    assert about_servos([log]) == []
    assert about_servos([wrong(log, speed=0.0)]) == []


def test_an_arm_that_comes_from_the_other_side_to_its_goal_is_not_asked_about() -> None:
    log = measured()
    comes = 0.4 * TIME / TIME[-1]
    away = {
        "yaw_rad": comes + 1.5 * np.exp(-TIME / 2.0),
        "yaw_rad_s": np.gradient(comes + 1.5 * np.exp(-TIME / 2.0), TIME),
    }
    for side in (1.0, -1.0):
        assert about_servos([replace(log, command=comes, outputs={name: side * y for name, y in away.items()})]) == []


def test_missing_readings_and_a_log_without_positions_are_borne() -> None:
    log = wrong(measured(), DEGREES)
    holey = {name: np.where(np.arange(len(TIME)) % 7 == 3, np.nan, y) for name, y in log.outputs.items()}
    (question,) = about_servos([replace(log, outputs=holey)])
    assert "57.3 times" in question
    assert about_servos([replace(log, outputs={"yaw_rad_s": log.outputs["yaw_rad_s"]})]) == []
    assert about_servos([replace(log, outputs={**log.outputs, "yaw_rad_s": np.full(len(TIME), np.nan)})]) != []


def test_a_speed_of_which_the_size_alone_is_logged_says_no_sign() -> None:
    log = measured(np.where(TIME < 2.0, 0.0, np.where(TIME < 5.0, -0.8, -1.3)))
    size = replace(log, outputs=log.outputs | {"yaw_rad_s": np.abs(log.outputs["yaw_rad_s"])})
    assert about_servos([log]) == about_servos([size]) == []
    noisy = replace(size, outputs=size.outputs | {"yaw_rad_s": size.outputs["yaw_rad_s"] - 1e-4})
    assert about_servos([noisy], unsigned=("yaw_rad_s",)) == []


def test_a_servo_that_is_driven_faster_than_it_can_follow_is_not_asked_about_its_sign() -> None:
    goal = 0.4 * np.sin(10.0 * TIME)
    late = replace(measured(goal), outputs={"yaw_rad": -0.9 * goal})
    assert about_servos([late]) == []
