"""What of a rig a MuJoCo model holds: servos, terms of the rig file, and what is left out of both."""

from dataclasses import replace
from math import inf

import pytest

from rwjax import RigError, parse_rig
from rwjax.export.mujoco_model import IN_THE_LOOP, mujoco_model
from rwjax.rig.model import Rig
from tests.systems import platform, reaction

SERVO = '[drive.servo]\nacts_on = "{}"\nkp = 20.0\nkd = 0.3\ndamping_on = "speed"\nlimit = 2.0\n'


def with_servo(rig: Rig, acts_on: str, **numbers: float) -> Rig:
    text = SERVO.format(acts_on)
    joint = parse_rig(
        f'kind = "joint"\n{text}[motor]\ntorque_constant = 0.02\nresistance = 2.0\n[axis]\ninertia = 0.1\n'
    )
    given = {name: value for name, value in joint.numbers.items() if name.startswith("drive.servo")}
    return replace(rig, servo=joint.servo, numbers=rig.numbers | given | numbers)


def test_a_servo_restores_whatever_the_sign_of_its_plant() -> None:
    forward, backward = (
        mujoco_model(with_servo(platform(), "voltage", **{"drive.gain": k})).drive for k in (0.4, -0.4)
    )
    assert forward.gain * forward.kp == backward.gain * backward.kp == pytest.approx(8.0)
    assert forward.force == backward.force == pytest.approx(0.8)
    assert mujoco_model(with_servo(platform(), "torque")).drive.gain == 0.4  # its drive turns any command into torque


def test_a_gain_of_zero_is_a_servo_all_the_same() -> None:
    drive = mujoco_model(with_servo(platform(), "voltage", **{"drive.servo.kp": 0.0})).drive
    assert drive.servo and drive.kp == 0.0 and drive.kd == pytest.approx(0.3)


def test_a_servo_of_a_reaction_wheel_is_left_out() -> None:
    model = mujoco_model(with_servo(reaction(), "voltage"))
    assert not model.drive.servo and {*model.left_out} == {"drive.servo"}


def test_what_lies_in_the_loop_is_left_out_and_what_lies_before_it_is_not() -> None:
    effects = {"drive.delay": {"tau": 0.02}, "sensor.delay": {"tau": 0.02}, "drive.goal_delay": {"tau": 0.03}}
    model = mujoco_model(replace(with_servo(platform(), "voltage"), effects=effects))
    assert model.left_out.items() >= {"drive.delay": IN_THE_LOOP, "sensor.delay": IN_THE_LOOP}.items()
    assert model.drive.goal_delay == 0.03 and {*model.held.effects} == {"drive.goal_delay"}


def test_a_joint_without_a_motor_takes_a_torque() -> None:
    rig = parse_rig('kind = "joint"\n[axis]\ninertia = 0.1\n')
    assert mujoco_model(rig).drive.gain == 1.0 and mujoco_model(rig).drive.force == inf
    only_current = replace(with_servo(rig, "voltage"), numbers=rig.numbers | {"motor.torque_constant": 0.02})
    with pytest.raises(RigError, match="resistance"):
        mujoco_model(only_current)


def test_negative_friction_is_said() -> None:
    model = mujoco_model(platform("viscous = -0.02"))
    assert model.axis.damping == 0.0 and "-0.02" in model.left_out["damping"]


def test_the_held_rig_lacks_only_what_is_left_out() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05\nstatic = 0.08\nstribeck_velocity = 0.1")
    effects = {
        "axis.spring": {"k": 0.5, "T_0": 0.1, "k_3": 0.2},
        "axis.backlash": {"g": 0.1, "s": 0.3, "k": 1.0, "c": 1.0},
    }
    model = mujoco_model(replace(rig, effects=effects))
    assert {*model.left_out} == {"axis.stribeck", "axis.spring", "axis.backlash"}
    assert model.held.effects == {"axis.spring": {"k": 0.5, "T_0": 0.1, "k_3": 0.0}}
    assert "axis.friction.static" not in model.held.numbers and model.held.numbers["axis.friction.coulomb"] == 0.05
    assert model.axis.frictionloss == 0.05 and model.axis.stiffness == 0.5
