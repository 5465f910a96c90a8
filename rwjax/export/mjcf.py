r"""A rig with one axis as a MuJoCo model (MJCF).

The axis is a hinge with `damping`, `frictionloss` and `armature`. The motor is a `general` actuator: its force is
$g\,a + b_0 + b_1\psi + b_2\dot\psi$, where $a$ is the command after its lag and its delay. Of a motor at voltage $V$ that is
$(K/R)(V - K\dot\psi)$; one with an inductance is MuJoCo's `dcmotor`. A servo's gains enter $g$, $b_1$ and $b_2$, as in MuJoCo's own `position` actuator.

A `reaction` rig is two hinges. MuJoCo keeps the term $J\ddot\psi$ of the wheel's equation, which the rig's equations leave out, as the
thesis does. The bodies' inertias make up for that: $I$ of the body alone, and $JI/(I - J)$ of the wheel. What the axis's own friction
makes of the wheel's rate stays, a share $J/I$ of it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from math import atan2, ceil, cos, hypot, inf, sin
from xml.etree import ElementTree as Xml

from rwjax.effects.library import BY_NAME
from rwjax.errors import RigError
from rwjax.export import Exported
from rwjax.rig.model import Rig

STEP = 1e-3
"""Time step of the model [s]."""
GRAVITY = 9.81
"""Gravity of the model [m/s²], which with the mass makes the torque of the rig's load."""
SHARE = 0.5
"""Share of the axis's inertia that the mass of its load has at most."""
ARM = 0.1
"""Longest arm of that mass [m]."""
SETTLES = 4.0
"""Time steps in which MuJoCo's dry friction settles, which it needs at least twice of."""


@dataclass(frozen=True)
class Hinge:
    """A hinge and what turns about it.

    Attributes:
        inertia: Of the body about the hinge [kg m²].
        armature: Inertia of the rotor, seen through the gear [kg m²].
        damping: Torque per rate [N m s/rad].
        frictionloss: Dry friction [N m].
        stiffness: Torque per angle [N m/rad].
        springref: Angle at which the spring is at rest [rad].
        constant: Constant torque [N m].
        sine: Torque of a load at a quarter of a turn, against the angle [N m].
        cosine: The same at angle 0 [N m].
    """

    inertia: float = 0.0
    armature: float = 0.0
    damping: float = 0.0
    frictionloss: float = 0.0
    stiffness: float = 0.0
    springref: float = 0.0
    constant: float = 0.0
    sine: float = 0.0
    cosine: float = 0.0


@dataclass(frozen=True)
class Drive:
    """The actuator.

    Attributes:
        gain: Torque per command.
        back: Torque per rate of the motor's hinge, its back-EMF [N m s/rad].
        winding: Time constant L/R of the current [s].
        offset: Offset of the command.
        limit: Largest command.
        lag: Time constant [s].
        delay: Delay of the command [s].
        kp: Gain of a servo, by which the command is a goal [command/rad]; 0 without one.
        kd: Gain of a servo by the rate [command s/rad].
    """

    gain: float
    back: float = 0.0
    winding: float = 0.0
    offset: float = 0.0
    limit: float = inf
    lag: float = 0.0
    delay: float = 0.0
    kp: float = 0.0
    kd: float = 0.0


@dataclass(frozen=True)
class Model:
    """What of a rig a MuJoCo model holds.

    Attributes:
        axis: The axis, or the wheel of a rig without one.
        drive: The actuator.
        wheel: The wheel that the body of the axis carries, where there is one.
        left_out: What is left out, and why.
    """

    axis: Hinge
    drive: Drive
    wheel: Hinge | None = None
    left_out: dict[str, str] = field(default_factory=dict)

    def plus(self, field: str, value: float) -> "Model":
        """With more of one thing.

        Args:
            field: a field of `Hinge` or `Drive`; of the wheel's hinge behind `wheel_`.
            value: what is added [the field's unit]; of a limit the lesser one counts.

        Returns:
            The model.
        """
        if field.startswith("wheel_"):
            field = field.removeprefix("wheel_")
            if self.wheel is not None:
                return replace(self, wheel=replace(self.wheel, **{field: getattr(self.wheel, field) + value}))
        if field in {f.name for f in fields(Drive)}:
            old = getattr(self.drive, field)
            return replace(
                self, drive=replace(self.drive, **{field: min(old, value) if field == "limit" else old + value})
            )
        return replace(self, axis=replace(self.axis, **{field: getattr(self.axis, field) + value}))

    def without(self, name: str, why: str) -> "Model":
        """With one more thing that is left out.

        Args:
            name: its name.
            why: why, in words.

        Returns:
            The model.
        """
        return replace(self, left_out=self.left_out | {name: why})


def mjcf(rig: Rig) -> Exported:
    """A rig with one axis as a MuJoCo model.

    Args:
        rig: The rig. Where it has a servo, the control is the goal [rad]; otherwise the voltage [V].

    Returns:
        The model's XML, and what it leaves out.

    Raises:
        RigError: For a rig with two axes, and for one that lacks what turns a voltage into torque.
    """
    if rig.kind not in _PLANTS:
        raise RigError(f"`{rig.name}`: kind `{rig.kind}` has no MuJoCo model; describe one axis by a `reaction` rig")
    model = _with_friction(_PLANTS[rig.kind](rig), rig)
    model = _with_servo(model, rig)
    for name, given in rig.effects.items():
        model = _with_effect(model, name, given)
    return Exported(_xml(rig, model), model.left_out)


def _number(rig: Rig, name: str) -> float:
    """A number of the rig file, 0 where it is left out."""
    return rig.numbers.get(name, 0.0)


def _platform(rig: Rig) -> Model:
    return Model(Hinge(inertia=rig.numbers["axis.inertia"]), Drive(rig.numbers["drive.gain"]))


def _motor(rig: Rig) -> Drive:
    """The motor as an actuator; its command is a voltage, or what a servo acts on."""
    for name in ("motor.torque_constant", "motor.resistance"):
        if name not in rig.numbers:
            raise RigError(f"`{rig.name}`: `{name}` is missing, without which a voltage makes no torque")
    K, R = rig.numbers["motor.torque_constant"] * rig.numbers.get("gear.ratio", 1.0), rig.numbers["motor.resistance"]
    return Drive(K / R, back=-(K**2) / R, winding=_number(rig, "motor.inductance") / R)


def _wheel(rig: Rig) -> Model:
    hinge = Hinge(inertia=rig.numbers["wheel.inertia"], damping=_number(rig, "motor.friction"))
    return Model(hinge, _motor(rig))


def _reaction(rig: Rig) -> Model:
    I, J = rig.numbers["axis.inertia"], rig.numbers["wheel.inertia"]
    if not I > J:
        raise RigError(f"`{rig.name}`: the axis's inertia holds the wheel's, and {I:g} kg m2 is not more than {J:g}")
    wheel = Hinge(inertia=J * I / (I - J), damping=_number(rig, "motor.friction"))
    return Model(Hinge(inertia=I), _motor(rig), wheel)


def _joint(rig: Rig) -> Model:
    N = rig.numbers.get("gear.ratio", 1.0)
    hinge = Hinge(inertia=rig.numbers["axis.inertia"], armature=N**2 * _number(rig, "motor.inertia"))
    return Model(hinge, _motor(rig))


_PLANTS: dict[str, Callable[[Rig], Model]] = {
    "platform": _platform,
    "wheel": _wheel,
    "reaction": _reaction,
    "joint": _joint,
}
"""The plant of each kind of rig."""


def _with_friction(model: Model, rig: Rig) -> Model:
    """Friction and load of the axis that the rig file models."""
    damping, level = _number(rig, "axis.friction.viscous"), _number(rig, "axis.friction.coulomb")
    if "axis.friction.b3" in rig.numbers:
        level, damping = level + rig.numbers["axis.friction.b3"], damping + rig.numbers["axis.friction.b2"]
        if _number(rig, "axis.friction.b1") or _number(rig, "axis.friction.b0"):
            model = model.without("axis.friction.polynomial", "its square and cube; level and slope are there")
    if _number(rig, "axis.friction.static") > level:
        model = model.without("axis.friction.static", "dry friction is the same at every rate there")
    torque, angle = _number(rig, "axis.gravity.torque"), _number(rig, "axis.gravity.angle")
    if rig.kind == "wheel":
        return model
    terms = {"damping": max(damping, 0.0), "frictionloss": max(level, 0.0)}
    terms |= {"sine": torque * cos(angle), "cosine": torque * sin(angle)}
    return replace(model, axis=replace(model.axis, **terms))


def _with_servo(model: Model, rig: Rig) -> Model:
    """The gains of a servo. Its control is then the goal."""
    if rig.servo is None:
        return model
    part = {name: _number(rig, f"drive.servo.{name}") for name in ("kp", "ki", "kd", "limit", "error_limit", "period")}
    scale = 1.0
    if rig.servo.acts_on == "duty":
        if "drive.supply" not in rig.numbers:
            raise RigError(f"`{rig.name}`: `drive.supply` is missing, without which a duty is no voltage")
        scale = rig.numbers["drive.supply"]
    elif rig.servo.acts_on == "current":
        gain = rig.numbers.get("motor.torque_constant", 1.0) * rig.numbers.get("gear.ratio", 1.0)
        model = replace(model, drive=Drive(gain))
    elif rig.servo.acts_on == "torque":
        model = replace(model, drive=Drive(1.0))
    if model.drive.winding:
        model = model.without("motor.inductance", "the current of a servo's actuator follows at once")
    for name, why in (
        ("ki", "an actuator has no integral of the error"),
        ("limit", "a limit before the back-EMF; set `forcerange` for one of the torque"),
        ("error_limit", "a limit of the error"),
        ("period", "the loop of an actuator acts at every step"),
    ):
        if part[name]:
            model = model.without(f"drive.servo.{name}", why)
    if part["kd"] and rig.servo.damping_on == "error":
        model = model.without("drive.servo.damping_on", "its rate gain multiplies the speed, not the error's rate")
    return replace(model, drive=replace(model.drive, kp=part["kp"] * scale, kd=part["kd"] * scale))


def _with_effect(model: Model, name: str, given: Mapping[str, float]) -> Model:
    """A model with what an effect adds to it."""
    effect = BY_NAME[name]
    added = effect.in_mujoco(given)
    if added is None:
        readings = name.startswith("sensor.")
        return model.without(name, "it belongs to the readings" if readings else "MuJoCo has no such part")
    if "lag" in added and model.drive.winding and not model.drive.kp:
        return model.without(name, "MuJoCo's DC motor takes its voltage without a lag")
    if "limit" in added and model.drive.kp:
        return model.without(name, "a limit before the back-EMF; set `forcerange` for one of the torque")
    if lacks := effect.mujoco_lacks(given):
        model = model.without(name, lacks)
    for key, value in added.items():
        model = model.plus(key, value)
    return model


def _xml(rig: Rig, model: Model) -> str:
    """The file."""
    root = Xml.Element("mujoco", model=rig.name)
    root.append(Xml.Comment(f" {rig.kind} rig `{rig.name}`, written by rwjax; units are SI "))
    Xml.SubElement(root, "compiler", angle="radian", autolimits="true")
    option = Xml.SubElement(root, "option", timestep=_text(STEP), integrator="implicitfast", gravity=f"0 0 {-GRAVITY}")
    Xml.SubElement(option, "flag", contact="disable")
    world = Xml.SubElement(root, "worldbody")
    axis = "wheel" if rig.kind == "wheel" else "axis"
    body = _body(world, axis, model.axis)
    if model.wheel is not None:
        _body(body, "wheel", model.wheel)
    actuators = Xml.SubElement(root, "actuator")
    driven = "wheel" if model.wheel is not None else axis
    _actuator(actuators, driven, model.drive)
    if model.drive.offset and model.drive.winding and not model.drive.kp:
        _constant(actuators, "offset", driven, model.drive.gain * model.drive.offset)
    if model.axis.constant:
        _constant(actuators, "constant_torque", axis, model.axis.constant)
    sensors = Xml.SubElement(root, "sensor")
    for name in (axis, *(["wheel"] if model.wheel is not None else [])):
        Xml.SubElement(sensors, "jointpos", name=f"{name}_rad", joint=name)
        Xml.SubElement(sensors, "jointvel", name=f"{name}_rad_s", joint=name)
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode") + "\n"


def _body(parent: Xml.Element, name: str, hinge: Hinge) -> Xml.Element:
    """A body on a hinge about the horizontal axis y; its load hangs down where `sine` alone is there and the angle is 0."""
    load = hypot(hinge.sine, hinge.cosine)
    arm = min(ARM, SHARE * hinge.inertia * GRAVITY / load) if load else 0.0
    mass = load / (GRAVITY * arm) if load else 1.0
    angle = atan2(hinge.cosine, hinge.sine)
    own = hinge.inertia - mass * arm**2
    body = Xml.SubElement(parent, "body", name=name)
    given = {
        "damping": hinge.damping,
        "frictionloss": hinge.frictionloss,
        "armature": hinge.armature,
        "stiffness": hinge.stiffness,
        "springref": hinge.springref,
    }
    joint = Xml.SubElement(body, "joint", name=name, type="hinge", axis="0 1 0")
    for key, value in given.items():
        if value:
            joint.set(key, _text(value))
    if hinge.frictionloss:
        joint.set("solreffriction", f"{_text(SETTLES * STEP)} 1")
        joint.set("solimpfriction", "0.9999 0.9999 0.001 0.5 2")
    at = f"{_text(-arm * sin(angle))} 0 {_text(-arm * cos(angle))}"
    # about the axis it counts; about the others it is only to be possible
    Xml.SubElement(*(body, "inertial"), pos=at, mass=_text(mass), diaginertia=f"{_text(own)} {_text(own)} {_text(own)}")
    return body


def _actuator(actuators: Xml.Element, joint: str, drive: Drive) -> None:
    """The actuator between the command and the hinge: a DC motor where a winding delays its current, and else one whose force is affine."""
    gain = drive.gain
    if drive.winding and not drive.kp:
        K = -drive.back / gain
        motor = {"motorconst": K, "resistance": K / gain, "inductance": drive.winding * K / gain}
        given = Xml.SubElement(actuators, "dcmotor", name="drive", joint=joint, input="voltage")
        for key, value in motor.items():
            given.set(key, _text(value))
    else:
        given = Xml.SubElement(actuators, "general", name="drive", joint=joint, biastype="affine")
        bias = (gain * drive.offset, -gain * drive.kp, drive.back - gain * drive.kd)
        given.set("gainprm", _text(gain * drive.kp if drive.kp else gain))
        given.set("biasprm", " ".join(map(_text, bias)))
        if drive.lag:
            given.set("dyntype", "filterexact")
            given.set("dynprm", _text(drive.lag))
    if drive.limit < inf:
        given.set("ctrlrange", f"{_text(-drive.limit)} {_text(drive.limit)}")
    if drive.delay:
        given.set("delay", _text(drive.delay))
        given.set("nsample", str(ceil(drive.delay / STEP) + 1))  # commands that MuJoCo remembers


def _constant(actuators: Xml.Element, name: str, joint: str, torque: float) -> None:
    """A constant torque, whatever its control."""
    given = Xml.SubElement(actuators, "general", name=name, joint=joint, gainprm="0", biastype="affine")
    given.set("biasprm", f"{_text(torque)} 0 0")


def _text(value: float) -> str:
    """A number with every digit that counts."""
    return f"{value:.9g}"
