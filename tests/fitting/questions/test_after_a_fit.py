"""Where numbers are guesses, a fit tells a command that is turned over and angles in degrees; right logs are not asked about."""

import re
from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, Rig, simulate
from rwjax.fitting.questions.after_a_fit import about_what_a_fit_leaves, turned_over
from rwjax.fitting.questions.ask import questions
from tests.joints import joint, logged, servo
from tests.systems import platform, record

TIME = np.arange(800) * 0.01
NUMBERS = ("motor.torque_constant", "axis.inertia", "axis.friction.viscous", "axis.gravity.torque")
TRUTH = joint(axis__gravity__torque=1.4)
GUESSES = replace(
    TRUTH.with_values(
        {name: TRUTH.values[name] * factor for name, factor in zip(NUMBERS, (0.4, 3.0, 0.3, 0.5), strict=True)}
    ),
    free=NUMBERS[1:],
)


def swung(seed: int, rig: Rig = TRUTH) -> Log:
    """A run of a hanging joint under random steps, at rest at first."""
    rng = np.random.default_rng(seed)
    volts = np.repeat(rng.choice([-3.0, -1.0, 0.0, 2.0, 4.0], 20), 40)
    y = np.asarray(simulate(rig, TIME, {"voltage_V": volts})["yaw_rad"]) + 1e-3 * rng.normal(size=len(TIME))
    return replace(record(TIME, volts, {"yaw_rad": y}), name=f"{seed}.csv")


LOGS = [swung(1), swung(2)]
DEGREES = [replace(log, outputs={"yaw_rad": np.degrees(log.outputs["yaw_rad"])}) for log in LOGS]


@pytest.mark.parametrize(
    ("logs", "says"),
    [
        (
            [turned_over(log) for log in LOGS],
            "with the command's sign turned over it follows the motion: is its sign wrong",
        ),
        (DEGREES, "with angles taken for degrees it follows the motion: are the readings in degrees"),
        ([turned_over(LOGS[0])], "with the command's sign turned over it follows the motion: is its sign wrong"),
    ],
)
def test_a_mistake_that_numbers_do_not_make_up_for_is_asked_about(logs: list[Log], says: str) -> None:
    (question,) = about_what_a_fit_leaves(GUESSES, logs)
    assert question.startswith("1.csv") and says in question
    assert re.search(r": as it is, a fit leaves (all|[3-9]\d %) of the motion, and with ", question)


@pytest.mark.parametrize("place", [0, 1])
def test_a_log_that_is_not_read_or_is_held_out_is_not_counted(place: int) -> None:
    wrong = [turned_over(log) for log in LOGS]
    blind = replace(LOGS[0], name="blind.csv", outputs={"yaw_rad": np.full(len(TIME), np.nan)})
    kept = replace(LOGS[1], name="kept.csv", validate=True)
    (question,) = about_what_a_fit_leaves(GUESSES, [*wrong[:place], blind, kept, *wrong[place:]])
    assert question.startswith("1.csv and 2.csv: ")


def test_readings_that_the_rig_does_not_have_are_not_asked_about() -> None:
    rig = replace(platform(), free=("axis.inertia",))
    log = record(TIME, 3.0 * np.sign(np.sin(TIME)), {"current_A": np.cos(TIME)})
    assert about_what_a_fit_leaves(rig, [log]) == [] == questions(rig, [log])


def test_a_command_before_a_log_is_turned_over_with_it() -> None:
    log = replace(LOGS[0], earlier=(np.array([-0.1]), np.array([2.0])))
    assert turned_over(log).earlier[1] == [-2.0] and turned_over(log).earlier[0] == [-0.1]


def test_right_logs_of_guessed_numbers_are_not_asked_about() -> None:
    assert questions(GUESSES, LOGS) == []


def test_nothing_is_asked_where_one_log_goes_as_it_is() -> None:
    assert about_what_a_fit_leaves(TRUTH, [LOGS[0], turned_over(LOGS[1])]) == []


def test_nothing_is_asked_where_one_log_is_followed_worse_without_the_mistake() -> None:
    logs = [turned_over(LOGS[0]), turned_over(LOGS[1]), swung(3)]
    assert len(about_what_a_fit_leaves(GUESSES, logs[:2])) == 1 and about_what_a_fit_leaves(GUESSES, logs) == []


def test_nothing_is_fitted_where_nothing_is_free_or_a_goal_is_commanded() -> None:
    wrong = [turned_over(log) for log in LOGS]
    assert about_what_a_fit_leaves(replace(GUESSES, free=()), wrong) == []
    rig = replace(servo(TRUTH), free=("axis.inertia",))
    goal = {"goal_rad": 0.3 * np.sign(np.sin(3.0 * TIME))}
    followed = logged(rig, TIME, **goal)
    assert about_what_a_fit_leaves(rig, [replace(followed, outputs={"yaw_rad": -followed.outputs["yaw_rad"]})]) == []
