"""Rates that contradict their angle are asked about; those that may be right, or tell too little, are not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.fitting.questions.ask import questions
from rwjax.fitting.questions.rates import about_rates
from rwjax.logs.log import Log
from tests.systems import platform, record, run

TIME = 0.01 * np.arange(600)
PUSH = 0.8 * np.sin(2.0 * TIME)


def measured() -> Log:
    """A platform's run with its angle and its rate, as they should be."""
    wanted = record(TIME, PUSH, {"yaw_rad": np.zeros_like(TIME), "yaw_rad_s": np.zeros_like(TIME)})
    return record(TIME, PUSH, run(platform(), wanted, {}))


def wrong(log: Log, angle: float = 1.0, rate: float = 1.0, offset: float = 0.0) -> Log:
    """A log with its columns multiplied, and an offset on its rate [rad/s]."""
    return replace(
        log,
        outputs={"yaw_rad": angle * log.outputs["yaw_rad"], "yaw_rad_s": rate * log.outputs["yaw_rad_s"] + offset},
    )


DEGREES = 180.0 / np.pi
MISTAKES = [
    (DEGREES, 1.0, "57.3 times as far as yaw_rad_s says: is yaw_rad in degrees"),
    (1.0, DEGREES, "0.0175 times as far as yaw_rad_s says: is yaw_rad_s in degrees per second"),
    (1.0, 30.0 / np.pi, "is yaw_rad_s in turns per minute?"),
    (1.0, 0.5 / np.pi, "is yaw_rad_s in turns per second?"),
    (0.5 / np.pi, 1.0, "is yaw_rad in turns?"),
    (
        -1.0,
        1.0,
        "yaw_rad goes against what yaw_rad_s says: is its sign wrong, or that of yaw_rad_s? `sign` in [columns]",
    ),
    (1.0, -DEGREES, "yaw_rad goes against what yaw_rad_s says"),
]


@pytest.mark.parametrize(("angle", "rate", "says"), MISTAKES)
def test_a_rate_in_another_unit_or_with_the_other_sign_is_asked_about(angle: float, rate: float, says: str) -> None:
    log = wrong(measured(), angle, rate)
    (question,) = about_rates([log, measured()])
    assert question.startswith("test.csv: yaw_rad ") and says in question
    assert question in questions(platform(), [log])


@given(angle=st.floats(0.7, 1.4), offset=st.floats(-0.05, 0.05), late=st.integers(0, 5), seed=st.integers(0, 99))
def test_a_rate_that_is_roughly_the_angles_is_not(angle: float, offset: float, late: int, seed: int) -> None:
    log = wrong(measured(), angle, 1.0, offset)
    rate = np.roll(log.outputs["yaw_rad_s"], late) + np.random.default_rng(seed).normal(0.0, 0.05, len(TIME))
    assert about_rates([replace(log, outputs=log.outputs | {"yaw_rad_s": rate})]) == []


def test_a_rate_that_follows_nothing_or_has_lost_its_sign_is_not() -> None:
    log = measured()
    noise = np.random.default_rng(0).normal(0.0, 1.0, len(TIME))
    size = np.abs(log.outputs["yaw_rad_s"])
    for rate in (noise, size, 0.0 * size, np.full(len(TIME), np.nan)):
        assert about_rates([replace(log, outputs=log.outputs | {"yaw_rad_s": DEGREES * rate})]) == []
    assert about_rates([wrong(log, -1.0)], unsigned=["yaw_rad_s"]) == []
    assert about_rates([replace(log, outputs={"yaw_rad": log.outputs["yaw_rad"]})]) == []


@pytest.mark.parametrize(("unit", "called"), [(1e3, "milli"), (1e6, "micro")])
def test_a_time_in_a_smaller_unit_shows_in_a_rate(unit: float, called: str) -> None:
    log = measured()
    (question,) = about_rates([replace(log, time=unit * log.time)])
    assert f"is time_s in {called}seconds?" in question


def test_a_run_in_one_direction_is_asked_about_its_unit_and_not_its_sign() -> None:
    run_up = record(TIME, PUSH, {"yaw_rad": 0.5 * TIME**2, "yaw_rad_s": TIME})
    for way in (1.0, -1.0):
        (question,) = about_rates([wrong(run_up, way, way * DEGREES)])
        assert "is yaw_rad_s in degrees per second" in question
    assert about_rates([wrong(run_up, -1.0)]) == []  # the size of a rate, as one hall sensor tells it
    wheel = replace(run_up, outputs={"wheel_rad": 0.5 * TIME**2, "wheel_rad_s": TIME * 30.0 / np.pi})
    (question,) = about_rates([wheel])
    assert "is wheel_rad_s in turns per minute?" in question


def test_logs_with_one_mistake_are_one_question_and_holes_are_borne() -> None:
    log = wrong(measured(), 1.0, DEGREES)
    holey = {name: np.where(np.arange(len(TIME)) % 7 == 3, np.nan, y) for name, y in log.outputs.items()}
    (question,) = about_rates([log, replace(log, name="second.csv", outputs=holey)])
    assert question.startswith("test.csv and second.csv: yaw_rad moves about 0.0175 times")
