"""A link that hangs is told by its logs, also where the command is turned over or the angle in degrees; other joints have no weight."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax import Log, Rig, simulate
from rwjax.fitting.questions.after_a_fit import turned_over
from rwjax.methods.first_estimates import WEIGHT, WEIGHT_ANGLE
from rwjax.methods.first_rig import Datasheet, first_rig
from rwjax.methods.hanging import hanging
from rwjax.methods.known import Known
from tests.joints import joint
from tests.systems import record

TIME = np.arange(1500) * 0.01


def with_weight(more: dict[str, Known]) -> Rig:
    """A first rig: guesses of the inertia and of friction, and the further numbers."""
    rig = joint(
        gear__ratio=1.0, motor__torque_constant=0.9, motor__inertia=0.0, axis__inertia=0.1, axis__friction__coulomb=0.01
    )
    free = (
        "axis.inertia",
        "axis.friction.viscous",
        "axis.friction.coulomb",
        *(n for n, known in more.items() if known.free),
    )
    return replace(rig, numbers=rig.numbers | {name: known.value for name, known in more.items()}, free=free)


def moved(seed: int, **numbers: float) -> Log:
    """A run of a joint under random steps."""
    truth = joint(
        gear__ratio=1.0,
        motor__torque_constant=0.9,
        motor__inertia=0.0,
        axis__inertia=0.03,
        axis__friction__coulomb=0.05,
        **numbers,
    )
    rng = np.random.default_rng(seed)
    volts = np.repeat(rng.choice([-4.0, -2.0, 0.0, 1.0, 3.0], 38), 40)[: len(TIME)]
    y = np.asarray(simulate(truth, TIME, {"voltage_V": volts})["yaw_rad"]) + 2e-3 * rng.normal(size=len(TIME))
    return replace(record(TIME, volts, {"yaw_rad": y}), name=f"{seed}.csv")


HANGS = [moved(seed, axis__gravity__torque=1.5) for seed in (1, 2)]


def in_degrees(log: Log) -> Log:
    return replace(log, outputs={"yaw_rad": np.degrees(log.outputs["yaw_rad"])})


def test_a_link_that_hangs_has_a_weight_to_be_estimated() -> None:
    found = hanging(with_weight, HANGS)
    assert found.numbers[WEIGHT].free and found.numbers[WEIGHT_ANGLE].value == 0.0 and found.logs is HANGS
    assert "take [axis.gravity] out" in found.notes[0]


@pytest.mark.parametrize(("wrong", "asks"), [(turned_over, "sign = -1"), (in_degrees, 'unit = "deg"')])
def test_a_mistake_that_hides_the_weight_is_said_and_undone(wrong: Callable[[Log], Log], asks: str) -> None:
    found = hanging(with_weight, [wrong(log) for log in HANGS])
    assert asks in found.notes[0] and found.numbers[WEIGHT].free
    for log, right in zip(found.logs, HANGS, strict=True):
        assert np.array_equal(log.command, right.command)
        assert log.outputs["yaw_rad"] == pytest.approx(right.outputs["yaw_rad"])


def test_a_link_that_stands_up_at_angle_0_is_no_mistake() -> None:
    about_pi = [replace(log, outputs={"yaw_rad": log.outputs["yaw_rad"] + np.pi}) for log in HANGS]
    found = hanging(with_weight, about_pi)
    assert found.logs is about_pi and WEIGHT in found.numbers


def test_a_measured_arm_that_is_led_by_hand_is_not_asked_about_its_sign(realdata: Path) -> None:
    """Its controller carries the weight: the torque goes with the sine, and hardly anything tells the inertia."""
    led = realdata / "dfki_simple_pendulum" / "gravity_compensation.csv"
    assert not any("sign" in note for note in first_rig([led], Datasheet(), "joint").notes)


def test_a_spring_is_not_taken_for_a_weight_in_degrees() -> None:
    sprung = joint(gear__ratio=1.0, motor__torque_constant=0.9, motor__inertia=0.0, axis__inertia=0.03)
    sprung = replace(sprung, effects={"axis.spring": {"k": 0.5, "T_0": 0.0, "k_3": 0.0}})
    volts = np.repeat(np.random.default_rng(5).choice([-4.0, -2.0, 0.0, 1.0, 3.0], 38), 40)[: len(TIME)]
    y = np.asarray(simulate(sprung, TIME, {"voltage_V": volts})["yaw_rad"])
    assert not any("degrees" in note for note in hanging(with_weight, [record(TIME, volts, {"yaw_rad": y})]).notes)


def test_a_joint_without_a_weight_has_none() -> None:
    level = [moved(seed) for seed in (3, 4)]
    found = hanging(with_weight, level)
    assert found.numbers == {} and found.notes == () and found.logs is level


def test_a_log_that_does_not_move_tells_none() -> None:
    still = replace(HANGS[0], command=0.0 * TIME, outputs={"yaw_rad": 0.0 * TIME})
    assert hanging(with_weight, [still]).numbers == {}
