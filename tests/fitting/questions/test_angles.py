"""Angles in degrees are asked about where the motion goes with the angle itself."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, Rig, simulate
from rwjax.fitting.questions.angles import about_degrees, angles_of, from_degrees, from_wide_degrees
from rwjax.fitting.questions.ask import questions
from rwjax.fitting.questions.likeness import Run
from tests.joints import joint
from tests.systems import platform, record, run

TIME = np.arange(800) * 0.01
RIG = joint(axis__gravity__torque=1.2, axis__friction__coulomb=0.05)
TRUTH = RIG.with_values({"axis.gravity.torque": 1.4, "axis.friction.coulomb": 0.07, "axis.inertia": 0.012})
COMMANDS = {
    "sine.csv": 3.0 * np.sin(2.0 * TIME),
    "square.csv": 2.0 * np.sign(np.sin(1.5 * TIME)),
    "over.csv": 12.0 * np.sin(0.8 * TIME),
}


def swung(name: str, times: float = 1.0, rig: Rig = TRUTH) -> Log:
    """A run of a hanging joint from 0.5 rad, its angle multiplied by a factor."""
    y = np.asarray(simulate(rig, TIME, {"voltage_V": COMMANDS[name]}, start={"psi": 0.5})["yaw_rad"])
    y = y + 1e-3 * np.random.default_rng(len(name)).normal(size=len(TIME))
    return replace(record(TIME, COMMANDS[name], {"yaw_rad": times * y}), name=name)


def test_degrees_of_a_hanging_joint_are_asked_about_once_and_sound_logs_are_not() -> None:
    assert questions(RIG, [swung(name) for name in COMMANDS]) == []
    (question,) = questions(RIG, [swung(name, np.degrees(1.0)) for name in COMMANDS])
    assert 'are the readings in degrees? Write unit = "deg"' in question and question.startswith(
        "sine.csv and 2 more: yaw_rad"
    )


@pytest.mark.parametrize("wrong", [{"axis.gravity.torque": 0.3}, {"gear.ratio": 20.0}, {"axis.friction.viscous": 3.0}])
def test_a_rig_file_far_off_asks_about_no_degrees(wrong: dict[str, float]) -> None:
    found = questions(RIG.with_values(wrong), [swung(name) for name in COMMANDS])
    assert not any("degrees" in question for question in found)


def test_counts_are_no_degrees_and_what_fits_as_it_is_is_not_simulated_anew() -> None:
    def never() -> list[Run]:
        raise AssertionError("simulated in vain")

    log = swung("sine.csv")
    counted = replace(log, resolution={"yaw_rad": 1e-3})
    assert angles_of(counted) == [] and from_degrees(counted).outputs["yaw_rad"] is log.outputs["yaw_rad"]
    far = {"yaw_rad": -3.0 * log.outputs["yaw_rad"]}
    assert about_degrees([Run(counted, far)], never) == [] == about_degrees([Run(log, log.outputs)], never)
    still = {"yaw_rad": 0.0 * log.outputs["yaw_rad"]}
    assert about_degrees([Run(log, still), Run(log, log.outputs)], never) == [] == about_degrees([], never)


def test_a_clock_ten_times_too_fast_is_not_taken_for_degrees() -> None:
    """An angle under a steady torque grows with the square of time: a hundred times too far is near 57."""
    rig, time = platform("viscous = 0.0005"), 0.02 * np.arange(1500)
    command = 2.0 * np.sin(0.25 * time) + 0.5
    y = run(rig, record(time, command), {"w": 0.1})["yaw_rad"]
    (question,) = questions(rig, [replace(record(0.1 * time, command, {"yaw_rad": y}), name="a.csv")])
    assert question.startswith("a.csv: 10 times faster") and "Multiply `time_s` by 10" in question


def test_no_degrees_where_one_of_several_logs_is_less_like_its_run_then() -> None:
    whole = [swung(name, np.degrees(1.0)) for name in ("sine.csv", "square.csv")]
    off = [Run(log, {"yaw_rad": 0.0 * log.outputs["yaw_rad"]}) for log in whole]
    right = [Run(from_degrees(log), from_degrees(log).outputs) for log in whole]
    (question,) = about_degrees(off, lambda: right)
    assert question.startswith("sine.csv and square.csv: yaw_rad taken for degrees")
    worse = [right[0], Run(right[1].log, {"yaw_rad": -right[1].log.outputs["yaw_rad"]})]
    assert about_degrees(off, lambda: worse) == []


def test_a_small_swing_tells_no_degrees_by_a_fit() -> None:
    """A sine is a line there, as the torque of a spring that is taken for degrees."""
    log = swung("sine.csv")
    assert from_wide_degrees(log) is log and np.ptp(log.outputs["yaw_rad"]) < 28.0
    degrees = swung("sine.csv", np.degrees(1.0))
    assert from_wide_degrees(degrees).outputs["yaw_rad"] == pytest.approx(log.outputs["yaw_rad"])
    unread = replace(log, outputs={"yaw_rad": np.full(len(TIME), np.nan)})
    assert from_wide_degrees(unread) is unread
