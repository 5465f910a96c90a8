"""All questions about logs: right ones raise none, every mistake one that names it."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.questions.mistakes import MISTAKES
from rwjax import Log, parse_rig, simulate
from rwjax.errors import LogError
from rwjax.fitting.questions.ask import questions
from rwjax.logs.findings import findings
from tests.fitting.questions.runs import LOGS, RIG, TIME
from tests.joints import joint, logged, servo
from tests.systems import record, wheel

ASKED = {
    "clock x10": "Divide `time_s` by 10",
    "clock /10": "Multiply `time_s` by 10",
    "PWM of 255": "PWM counts",
    "percent": "percent",
    "pulses in us": "us of a pulse",
    "command of another run": "square.csv: the readings do not follow the command",
    "constant reading": "yaw_rad stays the same while the command changes",
    "degrees": "are the readings in degrees",
    "1/min": "are the readings in rpm",
    "sign": "is its sign, or that of the command, wrong",
    "mV": "is the command in mV",
}


def test_right_logs_raise_no_question() -> None:
    assert questions(RIG, LOGS) == []
    for log in LOGS:
        assert questions(RIG, [log]) == []


def test_without_a_log_there_is_nothing_to_ask_about() -> None:
    with pytest.raises(LogError, match="^no log to ask about; give at least one$"):
        questions(RIG, [])


@pytest.mark.parametrize("mistake", MISTAKES)
def test_every_mistake_is_asked_about(mistake: str) -> None:
    found = questions(RIG, MISTAKES[mistake](LOGS))
    assert any(ASKED[mistake] in question for question in found)
    assert all(question.isprintable() and "?" in question for question in found)


def test_a_command_in_mv_is_not_asked_about_as_a_pwm_besides() -> None:
    whole = [replace(log, command=np.round(1000.0 * log.command)) for log in LOGS]
    (question,) = questions(RIG, whole)
    assert "is the command in mV" in question


@pytest.mark.filterwarnings("error")
def test_seconds_that_are_taken_for_thousandths_are_asked_about_though_the_run_then_lasts_a_few_ms() -> None:
    fast = [replace(log, time=1e-3 * log.time) for log in LOGS]
    (question,) = questions(RIG, fast)
    assert (
        question.startswith("square.csv and 2 more: 1000 times faster than") and "Multiply `time_s` by 1000" in question
    )
    assert question.endswith("or correct its unit in [columns]")
    (question,) = questions(RIG, [replace(log, time=1e3 * log.time, origin=1e3 * log.origin) for log in LOGS])
    assert question.endswith('Divide `time_s` by 1000, or write unit = "ms" for it in [columns]')
    rig = servo(joint())
    good = logged(rig, TIME, goal_rad=0.8 * np.sin(2.0 * TIME))
    (question,) = questions(rig, [replace(good, time=1e-3 * TIME)])
    assert question.startswith("run.csv: 1000 times faster than")


def test_a_servo_whose_readings_contradict_one_another_is_asked_about_that_alone() -> None:
    rig = servo(joint())
    good = logged(rig, TIME, goal_rad=0.8 * np.sin(2.0 * TIME))
    assert questions(rig, [good]) == []
    (question,) = questions(rig, [replace(good, outputs={"yaw_rad": np.rad2deg(good.outputs["yaw_rad"])})])
    assert question.startswith("run.csv: yaw_rad moves about 57.3 times as far as goal_rad says")


def test_a_log_that_does_not_begin_at_rest_is_asked_about_its_clock() -> None:
    moving = [log.cut(200, len(log.time)) for log in LOGS]
    assert questions(RIG, moving) == []
    assert any("Divide `time_s` by 10" in question for question in questions(RIG, MISTAKES["clock x10"](moving)))


def test_a_rig_that_stands_still_under_no_command_is_not_asked_about() -> None:
    still = [type(log)(**{**vars(log), "command": np.zeros(len(log.time))}) for log in LOGS]
    constant = MISTAKES["constant reading"](still)
    assert not any("stays the same" in question for question in questions(RIG, constant))


def test_a_current_of_a_rig_without_a_motor_is_no_reading_that_is_asked_about() -> None:
    rig = parse_rig(
        'kind = "joint"\naxis.inertia = 0.02\naxis.friction.viscous = 0.05\n'
        'drive.servo = { acts_on = "torque", kp = 4.0, kd = 0.2 }\n'
    )
    t = 0.01 * np.arange(600)
    goal = np.where(t > 0.6, np.sign(np.sin(2.0 * t)), 0.0)
    angle = np.asarray(simulate(rig, t, {"goal_rad": goal})["yaw_rad"])
    log = Log.from_arrays(rig, time=t, goal_rad=goal, position_rad=angle, current_A=np.abs(np.sin(t)))
    assert questions(rig, [log]) == []


def pulsed(log: Log) -> np.ndarray:
    """The size of a rate, 0 where no pulse comes."""
    return np.where(log.time < 0.6, 0.0, np.abs(log.outputs["yaw_rad_s"]))


def test_a_rate_without_its_sign_is_asked_about_in_place_of_the_command() -> None:
    sizes = [replace(log, outputs={"yaw_rad_s": pulsed(log)}) for log in LOGS]
    for logs in (sizes, sizes[:1]):
        (question,) = questions(RIG, logs)
        assert question.startswith("yaw_rad_s never goes below 0")
    rpm = [replace(log, outputs={"yaw_rad_s": 30.0 / np.pi * log.outputs["yaw_rad_s"]}) for log in sizes]
    assert ["unsigned" in question or "in rpm" in question for question in questions(RIG, rpm)] == [True, True]


def test_a_leap_is_asked_about_alone() -> None:
    leaping = replace(LOGS[1], outputs={"yaw_rad": LOGS[1].outputs["yaw_rad"] + np.where(TIME < 6.0, 0.0, 30.0)})
    (question,) = questions(RIG, [LOGS[0], leaping, LOGS[2]])
    assert question.startswith("chirp.csv: yaw_rad leaps from ") and " rad at 6 s and goes on" in question


def test_an_angle_that_wraps_or_is_not_read_is_not_asked_about_as_one_that_leaps() -> None:
    turned = replace(LOGS[1], outputs={"yaw_rad": np.where(TIME < 6.0, 0.0, 2.0 * np.pi) + LOGS[1].outputs["yaw_rad"]})
    unread = replace(LOGS[1], outputs=LOGS[1].outputs | {"wheel_rad": np.sin(TIME) + np.where(TIME < 6.0, 0.0, 9.0)})
    unread = replace(unread, resolution=unread.resolution | {"wheel_rad": 0.0})
    for log in (turned, unread):
        assert not any("leaps" in question for question in questions(RIG, [LOGS[0], log, LOGS[2]]))
    assert any(one.kind == "leap" for one in findings(unread))


def test_a_drop_out_is_asked_about_in_place_of_the_command() -> None:
    lost = (np.arange(1500) >= 600) & (np.arange(1500) < 700)
    far = 20.0 + np.where(lost, -20.0, LOGS[1].outputs["yaw_rad"])
    dropped = replace(LOGS[1], outputs={"yaw_rad": far})
    (question,) = questions(RIG, [LOGS[0], dropped, LOGS[2]])
    assert question.startswith("chirp.csv: yaw_rad is exactly 0 rad from 6 to 6.99 s, and jumps there and back")
    hangs = replace(
        LOGS[1], outputs={"yaw_rad": np.where(lost, LOGS[1].outputs["yaw_rad"][599], LOGS[1].outputs["yaw_rad"])}
    )
    assert questions(RIG, [LOGS[0], hangs, LOGS[2]]) == []


def test_a_fraction_taken_for_percent_is_asked_about_in_place_of_its_readings() -> None:
    rig = replace(wheel(0.0), numbers=wheel(0.0).numbers | {"drive.supply": 12.0})
    duty = np.where(TIME < 0.6, 0.0, 0.5 * np.sign(np.sin(2.0 * TIME)))
    angle = np.asarray(simulate(rig, TIME, {"duty": duty})["wheel_rad"])
    good = record(TIME, duty, {"wheel_rad": angle}, resolution={"wheel_rad": 2.0 * np.pi / 1024}, input="duty")
    assert questions(rig, [good]) == []
    (question,) = questions(rig, [replace(good, command=0.01 * duty)])
    assert "the command never passes 0.5 % of full power" in question and "counts" not in question
