"""What of a rig a MuJoCo model holds: servos, terms of the rig file, and what is left out of both."""

from dataclasses import replace
from math import inf
from typing import Any

import pytest

from rwjax import RigError, parse_rig
from rwjax.export.mujoco_model import IN_THE_LOOP, mujoco_model
from rwjax.rig.model import Rig
from tests.joints import joint, servo
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
    assert not model.drive.servo and {*model.left_out} == {*model.uncounted} == {"drive.servo"}


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
    assert model.held.numbers["axis.friction.viscous"] == 0.0 and not model.uncounted
    by_effect = mujoco_model(replace(platform("coulomb = 0.05"), effects={"axis.viscous": {"b": -0.03}}))
    assert {*by_effect.left_out} == {"damping"} and not by_effect.uncounted
    assert by_effect.held.numbers["axis.friction.viscous"] == 0.03  # makes up for the effect


def test_the_held_rig_has_of_a_duty_s_loop_what_an_actuator_has() -> None:
    given: dict[str, Any] = {
        "kd": 0.1,
        "ki": 0.4,
        "limit": 0.8,
        "error_limit": 0.5,
        "derivative_filter": 0.01,
        "period": 0.004,
    }
    rig = replace(servo(joint(drive__supply=12.0, motor__inductance=1e-3), "duty", **given), free=("drive.servo.ki",))
    model = mujoco_model(rig)
    lacks = {f"drive.servo.{name}" for name in (*given, "damping_on")} - {"drive.servo.kd"}
    assert {*model.left_out} == lacks | {"drive.supply", "motor.inductance"} and not model.uncounted
    held = {name: value for name, value in model.held.numbers.items() if name.startswith("drive.servo.")}
    assert held == pytest.approx(
        {"drive.servo.kp": 12.0 * 8.0, "drive.servo.kd": 12.0 * 0.1, "drive.servo.period": 0.001}
    )
    assert model.held.servo is not None and model.held.servo[:2] == ("voltage", "speed")
    assert "motor.inductance" not in model.held.numbers and model.held.free == ()
    of_torque = mujoco_model(servo(joint(), "torque", limit=0.8, period=0.001))
    assert of_torque.held.numbers["drive.servo.limit"] == 0.8  # as the actuator's force has it
    assert not of_torque.left_out  # nor the period, which is that of the model's steps


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
