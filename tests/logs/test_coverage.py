"""Splits that extrapolate: in speed, direction, size and sign of the command, its pace and its pauses; and other splits that do not."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, parse_rig
from rwjax.logs.coverage import Split, split_of
from tests.systems import platform, record

TIME = np.arange(2001) * 0.01


def _run(name: str, command: np.ndarray, rate: np.ndarray, *, validate: bool = False, **outputs: np.ndarray) -> Log:
    return replace(record(TIME, command, {"yaw_rad_s": rate, **outputs}, validate=validate), name=name)


SINE = np.sin(TIME)
USUAL = [_run("a.csv", 2.0 * SINE, SINE), _run("b.csv", 2.1 * SINE, 1.02 * np.cos(TIME))]


def test_a_split_within_what_is_covered_needs_no_word() -> None:
    found = split_of(platform(), [*USUAL, _run("held.csv", 2.0 * np.cos(TIME), SINE, validate=True)])
    assert found == Split() and found.said() == [] and found.json() == {"outside": [], "proposed": None}


@pytest.mark.parametrize(
    ("command", "rate", "quantity", "share"),
    [
        (2.0 * SINE, 3.0 * SINE, "yaw_rad_s", 0.74),  # beyond 1.2 of 3: 1 - 2/pi arcsin(0.4)
        (6.0 * SINE, SINE, "command [V]", 0.74),
        (2.0 * np.sin(6.0 * TIME), SINE, "change of command [V/s]", 0.89),  # beyond 2.1 of 11.8 V/s
        (0.0 * TIME, 0.0 * TIME, "command", 1.0),
    ],
)
def test_what_leaves_is_named_with_its_share(
    command: np.ndarray, rate: np.ndarray, quantity: str, share: float
) -> None:
    fitted = [replace(log, command=np.where(SINE > 0.0, 2.0, -2.0) if share == 1.0 else log.command) for log in USUAL]
    (worst,) = split_of(platform(), [*fitted, _run("held.csv", command, rate, validate=True)]).outside
    assert worst.log == "held.csv" and quantity in worst.quantity
    assert worst.share == pytest.approx(share, abs=0.03)


def test_the_other_direction_is_extrapolation() -> None:
    turned = [replace(log, outputs={"yaw_rad_s": np.abs(log.outputs["yaw_rad_s"])}) for log in USUAL]
    found = split_of(platform(), [*turned, _run("back.csv", 2.0 * SINE, -np.abs(SINE), validate=True)])
    assert found.outside[0].quantity == "yaw_rad_s [rad/s]" and found.outside[0].share > 0.9


def test_angles_count_where_gravity_makes_them_matter() -> None:
    logs = [
        replace(log, outputs={"yaw_rad": near + 0.3 * SINE}, validate=near > 0.0)
        for log, near in zip([*USUAL, USUAL[0]], (0.0, 0.0, 1.0), strict=True)
    ]
    heavy = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.gravity]\ntorque = 1.0\n[fit]\nfree = ["axis.inertia"]'
    )
    assert split_of(platform(), logs) == Split()
    assert split_of(heavy, logs).outside[0].quantity == "yaw_rad [rad]"


def test_a_run_that_the_others_cover_is_proposed() -> None:
    fast = _run("fast.csv", 6.0 * SINE, 3.0 * SINE, validate=True)
    found = split_of(platform(), [*USUAL, fast])
    assert found.proposed in {"a.csv", "b.csv"}
    (said,) = found.said()
    assert said.startswith("fast.csv is held out") and f"{found.proposed} would not" in said
    marked = [replace(log, validate=log.name == found.proposed) for log in (*USUAL, fast)]
    assert split_of(platform(), marked) == Split()  # what is proposed does not extrapolate


def test_without_marks_the_run_that_leaves_the_others_is_named() -> None:
    found = split_of(platform(), [*USUAL, _run("fast.csv", 6.0 * SINE, 3.0 * SINE)])
    assert [one.log for one in found.outside] == ["fast.csv"] and found.proposed in {"a.csv", "b.csv"}


def test_of_a_single_run_another_third_is_proposed() -> None:
    growing = np.where(TIME < 13.4, 1.0, 3.0) * np.sin(3.0 * TIME)
    found = split_of(platform(), [_run("one.csv", growing, growing)])
    assert found.outside[0].log.startswith("one.csv[") and found.proposed is not None
    assert "of one.csv in a file of its own" in found.proposed
    assert " is held out and leaves " in found.said()[0] and "; held out instead, " in found.said()[0]


@pytest.mark.parametrize("rests", [False, True])
def test_a_third_in_which_nothing_moves_is_not_proposed(rests: bool) -> None:
    """It would be held out in vain: where the beginning rests, the middle is the only other part."""
    size = np.where(TIME < 6.7, 0.0 if rests else 1.0, np.where(TIME < 13.4, 1.0, 3.0))
    found = split_of(platform(), [_run("one.csv", size * np.sin(3.0 * TIME), size * np.cos(3.0 * TIME))])
    assert found.outside[0].log.startswith("one.csv[") and found.proposed is not None
    assert found.proposed.startswith("6.67 to 13.34 s" if rests else "0 to 6.67 s")


def test_a_run_of_a_split_without_marks_is_judged_and_not_held_out() -> None:
    """Each of them is fitted, too."""
    fast = _run("fast.csv", 6.0 * SINE, 3.0 * SINE)
    (of_two,) = split_of(platform(), [USUAL[0], fast]).said()
    (of_three,) = split_of(platform(), [*USUAL, fast]).said()
    assert of_two.startswith("fast.csv, judged by a fit to the other run, leaves what that one covers: ")
    assert of_three.startswith("fast.csv, judged by a fit to the other runs, leaves what they cover: ")
    assert "is held out" not in of_two + of_three and "; held out alone, " in of_three
