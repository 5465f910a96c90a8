"""Why a step does not settle, by the numbers of a controller and of the friction."""

import math

import pytest

from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.unsettled import FRICTION, held_off, least_kp, why_unsettled

LAW = Controller(2.0, feedforward=0.6, deadband=0.1)


def test_an_axis_is_held_until_gain_and_feed_forward_break_it_loose() -> None:
    assert held_off(LAW, 1.0) == pytest.approx(0.2)  # (1 - 0.6) V / 2 V/rad
    assert held_off(LAW, 0.7) == pytest.approx(0.1)  # beyond the deadband it is let go
    assert held_off(LAW, 0.1) == pytest.approx(0.05) and held_off(LAW, 0.0) == 0.0
    assert held_off(LAW._replace(kp=0.0), 1.0) == math.inf


@pytest.mark.parametrize(("error", "kp"), [(0.2, 2.0), (0.05, 20.0)])
def test_the_least_gain_holds_the_axis_off_by_no_more_than_asked(error: float, kp: float) -> None:
    assert least_kp(LAW, 1.0, error) == pytest.approx(kp)
    assert held_off(LAW._replace(kp=kp), 1.0) == pytest.approx(error)
    assert least_kp(LAW, 0.5, 0.2) == 0.0


@pytest.mark.parametrize(
    ("law", "breakaway", "words"),
    [
        (
            LAW,
            5.0,
            "until the command is 5 V, and the step gives 2.6 V with these gains: the axis does not move at all",
        ),
        (
            LAW._replace(ki=2.0),
            5.0,
            "the step gives 2.6 V with these gains, and ki makes up for the rest only in 1.2 s",
        ),
        (LAW, 1.0, "at rest it stays up to 11° off"),
        (LAW, 0.0, "too slow"),
        (Controller(2.0), 1e-3, "too slow"),  # friction holds it off by less than counts
    ],
)
def test_the_reason_holds_the_volts(law: Controller, breakaway: float, words: str) -> None:
    assert words in why_unsettled(law, breakaway, -1.0, LoopTiming(0.01, counts=4096))


def test_what_friction_does_not_hold_is_a_steady_loads() -> None:
    held = held_off(LAW, 1.0)
    of_friction, of_both = (why_unsettled(LAW, 1.0, -1.0, LoopTiming(0.01), error) for error in (-held, -1.2 * held))
    assert (
        "load" not in of_friction
        and of_both == f"{of_friction}; the rest is a steady load's, such as gravity at that angle"
    )


def test_a_count_that_is_wider_than_the_band_is_the_reason_where_friction_is_not() -> None:
    coarse = LoopTiming(0.01, counts=256)
    why = why_unsettled(LAW, 0.0, math.radians(10.0), coarse)
    assert why.startswith("one count of the encoder is 1.4°") and "within 0.2°" in why
    assert "too slow" in why_unsettled(LAW, 0.0, math.radians(60.0), coarse)  # 1.2° are more than half a count
    assert why_unsettled(LAW, 5.0, math.radians(10.0), coarse).startswith(FRICTION)
