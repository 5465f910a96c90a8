"""A rig with one axis as a MuJoCo model (MJCF), for MuJoCo 4: a hinge about y with an actuator, and a second hinge for a reaction wheel."""

import re
from math import atan2, ceil, cos, hypot, inf, sin
from xml.etree import ElementTree as Xml

from rwjax.export import Exported
from rwjax.export.mujoco_model import STEP, Drive, Hinge, mujoco_model
from rwjax.rig.model import Rig

GRAVITY = 9.81
"""Gravity of the model [m/s²], which with the mass makes the torque of the rig's load."""
SHARE = 0.5
"""Share of the axis's inertia that the mass of its load has at most."""
ARM = 0.1
"""Longest arm of that mass [m]."""
PLACE = ("name", "joint", "type", "axis")
"""Attributes that say which element it is."""
SETTLES = 4.0
"""Time steps in which MuJoCo's dry friction settles; it needs two at the least."""


def mjcf(rig: Rig) -> Exported:
    """A rig with one axis as a MuJoCo model.

    Args:
        rig: The rig. Where it has a servo, the control is the goal [rad]; otherwise the voltage [V], or without a motor the torque [N m].

    Returns:
        The model's XML, and what it leaves out.

    Raises:
        RigError: For a rig with two axes, and for one that lacks what turns its command into torque.
    """
    model = mujoco_model(rig)
    root = Xml.Element("mujoco", model=rig.name)
    root.append(Xml.Comment(f" {rig.kind} rig, written by rwjax; units are SI "))
    root.extend(Xml.Comment(_in_comment(f"left out: {name}: {why}")) for name, why in model.left_out.items())
    Xml.SubElement(root, "compiler", angle="radian", autolimits="true")
    option = Xml.SubElement(root, "option", timestep=_text(STEP), integrator="implicitfast", gravity=f"0 0 {-GRAVITY}")
    Xml.SubElement(option, "flag", contact="disable")
    axis = "wheel" if rig.kind == "wheel" else "yaw"  # first words of the outputs' names
    body = _body(Xml.SubElement(root, "worldbody"), axis, model.axis)
    if model.wheel is not None:
        _body(body, "wheel", model.wheel)
    actuators = Xml.SubElement(root, "actuator")
    driven = "wheel" if model.wheel is not None else axis
    _actuator(actuators, driven, model.drive)
    if model.drive.offset and model.drive.is_dc_motor:
        _constant(actuators, "offset", driven, model.drive.gain * model.drive.offset)
    if model.axis.constant:
        _constant(actuators, "constant_torque", axis, model.axis.constant)
    sensors = Xml.SubElement(root, "sensor")
    for name in dict.fromkeys((axis, driven)):
        Xml.SubElement(sensors, "jointpos", name=f"{name}_rad", joint=name)
        Xml.SubElement(sensors, "jointvel", name=f"{name}_rad_s", joint=name)
    Xml.indent(root)
    own = () if model.wheel is not None else _own(body, actuators, model.drive)
    text = Xml.tostring(root, encoding="unicode") + "\n"
    return Exported(text, model.left_out, model.held, own, model.uncounted)


def _own(body: Xml.Element, actuators: Xml.Element, drive: Drive) -> tuple[str, ...]:
    """The attributes of hinge and actuators for a model of one's own; a servo without offset and lag as MuJoCo's `position`."""
    lines = []
    for element in (*body.iter("joint"), *actuators):
        tag, given = element.tag, {key: value for key, value in element.items() if key not in PLACE}
        if element.get("name") == "drive" and drive.servo and not drive.offset and not drive.lag:
            gains = {"kp": given.pop("gainprm"), "kv": _text(-float(given.pop("biasprm").split()[2]))}
            del given["biastype"]
            tag, given = "position", gains | given
        if given:
            lines.append(f"{tag}: " + " ".join(f'{key}="{value}"' for key, value in given.items()))
    return tuple(lines)


def _body(parent: Xml.Element, name: str, hinge: Hinge) -> Xml.Element:
    """A body on a hinge about the horizontal axis y; its load hangs down at angle 0 where `sine` alone is there."""
    load = hypot(hinge.sine, hinge.cosine)
    arm = min(ARM, SHARE * hinge.inertia * GRAVITY / load) if load else 0.0
    mass = load / (GRAVITY * arm) if load else 1.0
    angle, own = atan2(hinge.cosine, hinge.sine), _text(hinge.inertia - mass * arm**2)
    body = Xml.SubElement(parent, "body", name=name)
    joint = Xml.SubElement(body, "joint", name=name, type="hinge", axis="0 1 0")
    for key in ("damping", "frictionloss", "armature", "stiffness", "springref"):
        if value := getattr(hinge, key):
            joint.set(key, _text(value))
    if hinge.frictionloss:
        joint.set("solreffriction", f"{_text(SETTLES * STEP)} 1")
        joint.set("solimpfriction", "0.9999 0.9999 0.001 0.5 2")
    at = f"{_text(-arm * sin(angle))} 0 {_text(-arm * cos(angle))}"
    # about the hinge it counts; about the other axes it only has to be possible
    Xml.SubElement(body, "inertial", pos=at, mass=_text(mass), diaginertia=f"{own} {own} {own}")
    return body


def _actuator(actuators: Xml.Element, joint: str, drive: Drive) -> None:
    """The actuator between the command and the hinge."""
    gain = drive.gain
    if drive.is_dc_motor:
        K = -drive.back / gain
        motor = {"motorconst": K, "resistance": K / gain, "inductance": drive.winding * K / gain}
        given = Xml.SubElement(actuators, "dcmotor", name="drive", joint=joint, input="voltage")
        for key, value in motor.items():
            given.set(key, _text(value))
    else:
        given = Xml.SubElement(actuators, "general", name="drive", joint=joint, biastype="affine")
        bias = (gain * drive.offset, -gain * drive.kp, drive.back - gain * drive.kd)
        given.set("gainprm", _text(gain * drive.kp if drive.servo else gain))
        given.set("biasprm", " ".join(map(_text, bias)))
        if drive.lag:
            given.set("dyntype", "filterexact")
            given.set("dynprm", _text(drive.lag))
    if drive.limit < inf:
        given.set("ctrlrange", f"{_text(-drive.limit)} {_text(drive.limit)}")
    if drive.force < inf:
        given.set("forcerange", f"{_text(-drive.force)} {_text(drive.force)}")
    if delay := drive.goal_delay if drive.servo else drive.delay:
        given.set("delay", _text(delay))
        given.set("nsample", str(ceil(delay / STEP) + 1))  # controls that MuJoCo remembers; more for smaller steps


def _in_comment(text: str) -> str:
    """A text as a comment of XML holds it, in which no two dashes may follow each other."""
    return f" {re.sub('-(?=-)', '- ', text)} "


def _constant(actuators: Xml.Element, name: str, joint: str, torque: float) -> None:
    """A constant torque, whatever its control."""
    given = Xml.SubElement(actuators, "general", name=name, joint=joint, gainprm="0", biastype="affine")
    given.set("biasprm", f"{_text(torque)} 0 0")


def _text(value: float) -> str:
    """A number with every digit that counts, 0 without a sign."""
    return f"{value + 0.0:.9g}"
