"""MuJoCo models: their motion under commands is the rig's, and what they cannot hold is said."""

import os
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from rwjax import RigError, parse_rig, read_logs, read_rig, simulate
from rwjax.export.mjcf import mjcf
from rwjax.export.mujoco_model import mujoco_model
from rwjax.export.targets import moved_by
from rwjax.fitting.predict import predict
from rwjax.rig.model import Rig
from tests.joints import joint, logged, servo
from tests.systems import platform, reaction, wheel

if os.environ.get("RWJAX_FIRMWARE") != "required":  # where the continuous test sets it, nothing may be missing
    pytest.importorskip("mujoco", reason="playing a model needs the extra `mujoco`")

from experiments.exports.played import played

DATA = Path(__file__).resolve().parents[2] / "data"
TIME = 0.01 * np.arange(400)
VOLTS = 2.0 * np.sign(np.sin(2.0 * TIME)) * (TIME > 0.2) + np.sin(7.0 * TIME)
JOINT = """
kind = "joint"
[motor]
torque_constant = 0.02
resistance = 2.0
inertia = 1e-6
[gear]
ratio = 100.0
[axis]
inertia = 0.02
[axis.friction]
viscous = 0.01
coulomb = 0.05
[axis.gravity]
torque = 0.4
angle = 0.3
"""
SERVO = '[drive.servo]\nacts_on = "voltage"\nkp = 20.0\nkd = 0.3\ndamping_on = "speed"\n'


def off_by(rig: Rig, command: np.ndarray, column: str = "voltage_V", start: dict[str, float] | None = None) -> float:
    """Error of the played model at the axis, or the wheel of a rig without one, over the range of the motion [1]."""
    start = start or {}
    name = "wheel_rad_s" if rig.kind == "wheel" else "yaw_rad"
    first = {"yaw_rad": start.get("psi", 0.0), "yaw_rad_s": start.get("w", 0.0)}
    found = played(mjcf(rig).text, TIME, command, first)[name]
    ours = simulate(rig, TIME, {column: command}, start=start)
    return float(np.max(np.abs(found - np.asarray(ours[name]))) / np.ptp(found))


@pytest.mark.parametrize(
    ("rig", "most"),
    [
        (platform("viscous = 0.02"), 1e-3),
        (platform("viscous = 0.02\ncoulomb = 0.3"), 1e-2),  # MuJoCo's dry friction is soft
        (wheel(inductance=0.0), 1e-3),
        (wheel(), 2e-3),  # MuJoCo's DC motor, by steps of 1 ms; steps of 0.25 ms are off by a quarter of that
        (parse_rig(JOINT), 1e-2),
    ],
)
def test_the_model_moves_as_the_rig_does(rig: Rig, most: float) -> None:
    assert off_by(rig, VOLTS, start={"psi": 0.4} if rig.kind == "joint" else None) < most


def test_a_wheel_turns_its_body_as_the_equations_say_that_drop_the_wheel_s_share() -> None:
    rig = reaction("viscous = 0.0")
    still = replace(rig, numbers=rig.numbers | {"motor.inductance": 0.0, "wheel.inertia": 0.01})
    assert off_by(still, VOLTS) < 1e-3


@pytest.mark.parametrize(
    ("effect", "given"),
    [
        ("axis.bias_torque", {"T": 0.1}),
        ("axis.imbalance", {"s": 0.3, "c": -0.2}),
        ("axis.spring", {"k": 0.5, "T_0": 0.1, "k_3": 0.0}),
        ("axis.viscous", {"b": 0.05}),
        ("axis.asymmetric_friction", {"M_c": 0.3, "d": 0.1}),
        ("drive.bias", {"u_b": 0.3}),
        ("drive.lag", {"T": 0.1, "q": 0.0}),
        ("drive.delay", {"tau": 0.05}),
        ("drive.saturation", {"u_m": 1.2, "n": 5000.0}),
    ],
)
def test_an_effect_that_the_model_holds_moves_it_as_the_rig(effect: str, given: dict[str, float]) -> None:
    rig = platform("viscous = 0.02")
    with_it = replace(rig, effects={effect: given})
    assert not mjcf(with_it).left_out
    assert off_by(with_it, VOLTS) < (1e-2 if "M_c" in given else 3e-3)  # its dry friction is soft
    plain = played(mjcf(rig).text, TIME, VOLTS)["yaw_rad"]
    assert np.ptp(played(mjcf(with_it).text, TIME, VOLTS)["yaw_rad"] - plain) > 0.05 * np.ptp(plain)


def test_the_control_of_a_servo_is_its_goal() -> None:
    rig = parse_rig(JOINT + SERVO)
    assert off_by(rig, 0.5 * np.sign(np.sin(3.0 * TIME)), "goal_rad") < 1e-2


@pytest.mark.slow
def test_the_number_of_a_clipped_duty_is_how_far_the_played_model_is_off() -> None:
    rig = servo(joint(drive__supply=12.0, axis__friction__coulomb=0.05), "duty", kp=2.5, period=0.001)
    rig = replace(rig, effects={"axis.spring": {"k": 0.5, "T_0": 0.0, "k_3": 0.3}})
    goal = 1.5 * np.sign(np.sin(3.0 * TIME)) * (TIME > 0.6)
    log = logged(rig, TIME, goal_rad=goal)
    found = mjcf(rig)
    assert found.held is not None
    ours = predict(rig, log).columns["yaw_rad"]
    off = float(np.sqrt(np.mean((played(found.text, TIME, goal)["yaw_rad"] - ours) ** 2)))
    without_spring = replace(rig, effects={"axis.spring": {"k": 0.5, "T_0": 0.0, "k_3": 0.0}})
    assert moved_by(rig, found.held, [log])["yaw_rad"] == pytest.approx(off, rel=0.02)
    assert off > 3.0 * moved_by(rig, without_spring, [log])["yaw_rad"]


def test_the_number_of_friction_that_falls_with_speed_is_how_far_the_played_model_is_off() -> None:
    rig = read_rig(DATA / "thesis" / "yaw.toml")
    (log,) = read_logs([DATA / "testbed" / "square.csv"], rig)
    found = mjcf(rig)
    assert found.held is not None and not found.uncounted
    ours = predict(rig, log).columns["yaw_rad"]
    off = float(np.sqrt(np.mean((played(found.text, log.time, log.command)["yaw_rad"] - ours) ** 2)))
    assert moved_by(rig, found.held, [log])["yaw_rad"] == pytest.approx(off, rel=0.05) and off > 0.015


@pytest.mark.parametrize("viscous", ["", "viscous = 0.01\n"])
def test_a_negative_effect_is_made_up_for_in_the_held_rig(viscous: str) -> None:
    rig = replace(platform(f"{viscous}coulomb = 0.3"), effects={"axis.viscous": {"b": -0.03}})
    found = mjcf(rig)
    assert found.held is not None
    model = played(found.text, TIME, VOLTS)["yaw_rad"]
    held, ours = (np.asarray(simulate(r, TIME, VOLTS)["yaw_rad"]) for r in (found.held, rig))
    assert np.max(np.abs(model - held)) < 0.1 * np.max(np.abs(model - ours))


def test_the_file_says_what_it_leaves_out_and_is_still_a_model() -> None:
    rig = replace(
        servo(joint(axis__friction__coulomb=-0.05), "voltage", ki=3.0),
        effects={"axis.backlash": {"d": 0.01, "J_m": 1e-3}, "sensor.delay": {"tau": 0.01}},
    )
    found = mjcf(rig)
    comments = re.findall("<!-- left out: (.*?): (.*?) -->", found.text)
    assert dict(comments) == found.left_out and len(comments) > 3
    assert Xml.fromstring(found.text).find("actuator") is not None


def test_dashes_of_a_reason_end_no_comment(monkeypatch: pytest.MonkeyPatch) -> None:
    model = replace(mujoco_model(joint()), left_out={"a.b": "see --volts, a---b and --"})
    monkeypatch.setattr("rwjax.export.mjcf.mujoco_model", lambda rig: model)
    text = mjcf(joint()).text
    assert "<!-- left out: a.b: see - -volts, a- - -b and - - -->" in text and Xml.fromstring(text).tag == "mujoco"


def test_no_number_of_a_model_is_a_minus_zero() -> None:
    text = mjcf(servo(joint(axis__gravity__torque=0.4), "torque", limit=1.0)).text
    assert 'pos="0 0 -0.' in text and not re.search(r'[" ]-0[" ]', text)


@pytest.mark.parametrize(
    ("text", "actuator"),
    [
        (JOINT, "general"),
        (JOINT + SERVO, "position"),
        (JOINT + SERVO + '[effects."drive.goal_delay"]\ntau = 0.03\n', "position"),
        (
            JOINT + SERVO + '[effects."drive.bias"]\nu_b = 0.5\n[effects."axis.spring"]\nk = 0.2\nT_0 = 0.05\n',
            "general",
        ),
        (JOINT + '[effects."axis.bias_torque"]\nT = 0.1\n[effects."drive.lag"]\nT = 0.05\n', "general"),
        (JOINT.replace("inertia = 1e-6", "inertia = 1e-6\ninductance = 0.002"), "dcmotor"),
    ],
)
def test_what_is_copied_into_a_model_of_one_s_own_makes_it_move_alike(text: str, actuator: str) -> None:
    found = mjcf(parse_rig(text))
    root = Xml.fromstring(found.text)
    (hinge,), actuators = [*root.iter("joint")], root.find("actuator")
    assert actuators is not None
    hinge.attrib = {key: hinge.attrib[key] for key in ("name", "type", "axis")}
    actuators.clear()
    tags = [line.split(":")[0] for line in found.own]
    assert tags[:2] == ["joint", actuator]
    for k, line in enumerate(found.own):
        element = Xml.SubElement(actuators, tags[k], name=f"a{k}", joint="yaw") if k else hinge
        for key, value in re.findall(r'(\w+)="([^"]+)"', line):
            element.set(key, value)
    command, start = 2.0 * np.sign(np.sin(3.0 * TIME)), {"yaw_rad": 0.0, "yaw_rad_s": 0.0}
    here, there = (
        played(text, TIME, command, start)["yaw_rad"] for text in (found.text, Xml.tostring(root, "unicode"))
    )
    assert np.ptp(here) > 0.1 and there == pytest.approx(here, abs=1e-9)


def test_two_axes_have_no_model() -> None:
    with pytest.raises(RigError, match="two_axis"):
        mjcf(replace(reaction(), kind="two_axis"))


def test_names_of_all_letters_stand_in_the_model() -> None:
    assert off_by(replace(platform(), name='a--b <">& ü'), VOLTS) < 1e-2


def test_a_dead_zone_applied_to_the_command_before_the_actuator_makes_up_for_the_model_s_lack() -> None:
    rig = replace(platform("viscous = 0.02"), effects={"drive.deadzone": {"u_0": 0.8, "j": 0.0}})
    found = mjcf(rig)
    assert "apply it to the command before the actuator" in found.left_out["drive.deadzone"]
    past = np.sign(VOLTS) * np.maximum(np.abs(VOLTS) - 0.8, 0.0)
    as_it_is, told = (played(found.text, TIME, u)["yaw_rad"] for u in (VOLTS, past))
    ours = np.asarray(simulate(rig, TIME, VOLTS)["yaw_rad"])
    assert np.max(np.abs(told - ours)) < 1e-3 * np.ptp(ours) < 0.1 * np.max(np.abs(as_it_is - ours))
