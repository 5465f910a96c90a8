r"""What of a rig a MuJoCo model holds: hinges, an actuator, and what is left out.

The motor is a `general` actuator: its force is $g\,a + b_0 + b_1\psi + b_2\dot\psi$ with the control $a$. Of a motor at voltage $V$ that
is $(K/R)(V - K\dot\psi)$; one with an inductance is MuJoCo's `dcmotor`. A servo's gains enter $g$, $b_1$ and $b_2$, as in MuJoCo's own
`position` actuator; its control is the goal.

A `reaction` rig is two hinges. MuJoCo keeps the term $J\ddot\psi$ of the wheel's equation, which the rig's equations leave out, as the
thesis does. The bodies' inertias make up for that: $I$ of the body alone, and $JI/(I - J)$ of the wheel. What torques on the axis besides
the motor's make of the wheel's rate stays, a share $J/I$ of it.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from math import copysign, inf

from rwjax.effects.effect import Effect
from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import Clock, CommandDelay, CommandFilter, CommandMap, Encoder, EncoderDelay, Reading
from rwjax.effects.rig_terms import terms_of
from rwjax.errors import RigError
from rwjax.export.instead import OWN_LOOP, instead
from rwjax.rig.model import Rig, Servo

IN_THE_LOOP = f"it acts inside the servo's loop, where an actuator has no place for it; {OWN_LOOP}"
STEP = 1e-3
"""Time step of the model [s]."""
SERVO_OF_WHEEL = "an actuator's loop reads the joint that it drives, here the wheel; the control is the voltage"


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

    inertia: float
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
        goal_delay: Delay of a servo's goal [s].
        servo: Whether the control is the goal of a servo.
        kp: Its gain [command/rad].
        kd: Its gain by the rate [command s/rad].
        force: Largest torque [N m].
    """

    gain: float
    back: float = 0.0
    winding: float = 0.0
    offset: float = 0.0
    limit: float = inf
    lag: float = 0.0
    delay: float = 0.0
    goal_delay: float = 0.0
    servo: bool = False
    kp: float = 0.0
    kd: float = 0.0
    force: float = inf

    @property
    def is_dc_motor(self) -> bool:
        """Whether its current follows the voltage late, which MuJoCo's `dcmotor` alone knows."""
        return self.winding > 0.0 and not self.servo


@dataclass(frozen=True)
class Model:
    """What of a rig a MuJoCo model holds.

    Attributes:
        axis: The axis, or the wheel of a rig without one.
        drive: The actuator.
        held: The rig without what is left out, as far as a rig file can say it.
        wheel: The wheel that the body of the axis carries, where there is one.
        left_out: What is left out, and why.
        uncounted: What of that `held` has all the same, as no rig file is without it.
    """

    axis: Hinge
    drive: Drive
    held: Rig
    wheel: Hinge | None = None
    left_out: dict[str, str] = field(default_factory=dict)
    uncounted: tuple[str, ...] = ()

    def plus(self, name: str, value: float) -> "Model":
        """With more of one thing.

        Args:
            name: A field of `Hinge` or `Drive`; of the wheel's hinge behind `wheel_`.
            value: What is added [the field's unit]; of a limit the lesser one counts.

        Returns:
            The model.
        """
        part = "drive" if name in {f.name for f in fields(Drive)} else "axis"
        if name.startswith("wheel_"):
            name, part = name.removeprefix("wheel_"), "axis" if self.wheel is None else "wheel"
        old = getattr(getattr(self, part), name)
        new = min(old, value) if name == "limit" else old + value
        return replace(self, **{part: replace(getattr(self, part), **{name: new})})

    def without(self, name: str, why: str, held: Rig | None = None) -> "Model":
        """With one more thing that is left out.

        Args:
            name: Its name.
            why: Why, in words.
            held: The rig without it; None where no rig file is without it.

        Returns:
            The model.
        """
        left_out = self.left_out | {name: why}
        if held is None:
            return replace(self, left_out=left_out, uncounted=(*self.uncounted, name))
        return replace(self, left_out=left_out, held=held)


def mujoco_model(rig: Rig) -> Model:
    """What of a rig a MuJoCo model holds.

    Args:
        rig: A rig with one axis.

    Returns:
        The model.

    Raises:
        RigError: For a rig with two axes, and for one that lacks what turns its command into torque.
    """
    if rig.kind not in _PLANTS:
        raise RigError(f"kind `{rig.kind}` has no MuJoCo model; describe one axis by a `reaction` rig")
    model = _with_servo(_PLANTS[rig.kind](rig), rig)
    if rig.kind != "wheel":
        for effect, given in terms_of(rig.numbers):
            model = _with_effect(model, effect, given)
    for name, given in rig.effects.items():
        model = _with_effect(model, BY_NAME[name], given)
    for name, part, numbers in _FRICTION:
        if (value := getattr(model.axis, name)) < 0.0:
            why = f"{part} of {value:.3g} is negative, 0 stands for it"
            model = model.plus(name, -value).without(name, why, _raised(model.held, numbers, -value))
    return model


_FRICTION = (
    ("damping", "viscous friction", ("axis.friction.b2", "axis.friction.viscous")),
    ("frictionloss", "dry friction", ("axis.friction.b3", "axis.friction.coulomb")),
)
"""Friction that a hinge cannot have below 0: its attribute, what it is, and the numbers of a rig file of which one makes up for it."""


def _raised(rig: Rig, names: Sequence[str], by: float) -> Rig:
    """A rig with more of the first of these numbers that its file has; of the last one where it has none."""
    name = next((name for name in names if name in rig.numbers), names[-1])
    return replace(rig, numbers=rig.numbers | {name: _number(rig, name) + by})


def _number(rig: Rig, name: str) -> float:
    """A number of the rig file, 0 where it is left out."""
    return rig.numbers.get(name, 0.0)


def _platform(rig: Rig) -> Model:
    return Model(Hinge(rig.numbers["axis.inertia"]), Drive(rig.numbers["drive.gain"]), rig)


def _motor(rig: Rig) -> Drive:
    """The motor as an actuator; its command is what a servo acts on, or the voltage, or without a motor the torque."""
    N, acts_on = rig.numbers.get("gear.ratio", 1.0), rig.servo.acts_on if rig.servo is not None else "voltage"
    K, R = rig.numbers.get("motor.torque_constant"), rig.numbers.get("motor.resistance")
    if acts_on == "torque" or (rig.servo is None and K is None):
        return Drive(1.0)
    if K is None:
        raise RigError("`motor.torque_constant` is missing, without which a current makes no torque")
    if acts_on == "current":
        return Drive(N * K)
    if R is None:
        raise RigError("`motor.resistance` is missing, without which a voltage makes no torque")
    return Drive(N * K / R, back=-((N * K) ** 2) / R, winding=_number(rig, "motor.inductance") / R)


def _wheel(rig: Rig) -> Model:
    return Model(Hinge(rig.numbers["wheel.inertia"], damping=_number(rig, "motor.friction")), _motor(rig), rig)


def _reaction(rig: Rig) -> Model:
    I, J = rig.numbers["axis.inertia"], rig.numbers["wheel.inertia"]
    if not I > J:
        raise RigError(f"the axis's inertia holds the wheel's, and {I:g} kg m2 is not more than {J:g}")
    wheel = Hinge(J * I / (I - J), damping=_number(rig, "motor.friction"))
    return Model(Hinge(I), _motor(replace(rig, servo=None)), rig, wheel)


def _joint(rig: Rig) -> Model:
    N = rig.numbers.get("gear.ratio", 1.0)
    return Model(Hinge(rig.numbers["axis.inertia"], armature=N**2 * _number(rig, "motor.inertia")), _motor(rig), rig)


_PLANTS: dict[str, Callable[[Rig], Model]] = {
    "platform": _platform,
    "wheel": _wheel,
    "reaction": _reaction,
    "joint": _joint,
}
"""The plant of each kind of rig."""
_LACKING = {
    "ki": f"an actuator has no integral of the error; {OWN_LOOP}",
    "error_limit": f"an actuator has no limit of the error; {OWN_LOOP}",
    "derivative_filter": "its rate is not filtered",
    "period": "the loop of an actuator acts at every step",
    "phase": "the loop of an actuator acts at every step",
}
"""Numbers of a servo that an actuator does not know."""


def _with_servo(model: Model, rig: Rig) -> Model:
    """The gains of a servo. Its control is then the goal."""
    if rig.servo is None:
        return model
    if model.wheel is not None:
        return model.without("drive.servo", SERVO_OF_WHEEL)
    scale = copysign(1.0, model.drive.gain)
    if rig.servo.acts_on == "duty":
        if "drive.supply" not in rig.numbers:
            raise RigError(
                "`drive.supply` is missing, without which a duty is no voltage; write [drive] supply = 12 (volts), "
                "or give logs that hold `supply_V`"
            )
        scale *= rig.numbers["drive.supply"]
    limit, force = _number(rig, "drive.servo.limit"), inf
    if limit and (rig.servo.acts_on in ("current", "torque") or rig.kind == "platform"):
        force = abs(model.drive.gain) * limit
    left = _left_of_servo(rig, rig.servo, limited=force < inf)
    held = _by_actuator(rig, rig.servo, left)
    for name, why in left.items():
        model = model.without(name, why, held)
    kp, kd = (scale * _number(rig, f"drive.servo.{name}") for name in ("kp", "kd"))
    return replace(model, drive=replace(model.drive, servo=True, kp=kp, kd=kd, force=force))


def _left_of_servo(rig: Rig, servo: Servo, limited: bool) -> dict[str, str]:
    """What of a servo an actuator does not have, and why; `limited` where its force has the limit of the servo."""
    left = {}
    if servo.acts_on == "duty":
        left["drive.supply"] = "the duty is not clipped at 1, and the supply does not change"
    if _number(rig, "motor.inductance") and servo.acts_on in ("voltage", "duty"):
        left["motor.inductance"] = "the current of a servo's actuator follows at once"
    most = {"period": STEP}  # up to which the model's steps are as good
    left |= {
        f"drive.servo.{name}": why
        for name, why in _LACKING.items()
        if abs(_number(rig, f"drive.servo.{name}")) > most.get(name, 0.0)
    }
    if _number(rig, "drive.servo.kd") and servo.damping_on == "error":
        left["drive.servo.damping_on"] = "its rate gain multiplies the speed, not the error's rate"
    if _number(rig, "drive.servo.limit") and not limited:
        left["drive.servo.limit"] = "it limits the voltage before the back-EMF"
    return left


def _by_actuator(rig: Rig, servo: Servo, left: Collection[str]) -> Rig:
    """A rig whose servo lacks what is left out: gains of the goal's error and of the speed alone, at every step of the model."""
    volts = rig.numbers["drive.supply"] if servo.acts_on == "duty" else 1.0
    gains = {name: volts * _number(rig, name) for name in ("drive.servo.kp", "drive.servo.kd")}
    kept = {name: value for name, value in rig.numbers.items() if name not in left or name == "drive.supply"}
    period = {"drive.servo.period": min(_number(rig, "drive.servo.period") or STEP, STEP)}
    acts_on = "voltage" if servo.acts_on == "duty" else servo.acts_on
    servo = servo._replace(acts_on=acts_on, damping_on="speed")
    return replace(rig, servo=servo, numbers=kept | gains | period, free=(), per_run=(), tied={})


def _with_effect(model: Model, effect: type[Effect], given: Mapping[str, float]) -> Model:
    """A model with what an effect adds to it."""
    name, drive, added = effect.name, model.drive, effect.in_mujoco(given)
    if refused := _refused(drive, effect, added):
        kept = {other: numbers for other, numbers in model.held.effects.items() if other != name}
        return model.without(name, refused, replace(model.held, effects=kept))
    known = parameters(effect)
    for number, what in effect.mujoco_drops.items():
        null = known[number].null if number in known else 0.0
        if given.get(number, null) != null:
            model = model.without(name, _to_do(what, effect), _lacking(model.held, effect, number, null))
    for key, value in (added or {}).items():
        model = model.plus(key, value)
    return model


def _lacking(rig: Rig, effect: type[Effect], number: str, null: float) -> Rig:
    """A rig whose effect has one number at its null, also where the rig file models the effect by numbers of its own."""
    if effect.name in rig.effects:
        return rig.with_values({f"{effect.name}.{number}": null})
    if f"axis.friction.{number}" in rig.numbers:
        return rig.with_values({f"axis.friction.{number}": null})
    return replace(rig, numbers={name: value for name, value in rig.numbers.items() if name not in effect.modelled_by})


def _refused(drive: Drive, effect: type[Effect], added: Mapping[str, float] | None) -> str:
    """Why a model cannot hold an effect at all, "" where it can."""
    if added is None and issubclass(effect, Encoder | EncoderDelay | Reading | Clock):
        return IN_THE_LOOP if drive.servo else _to_do("it belongs to the readings", effect)
    if added is None:
        inside = drive.servo and issubclass(effect, CommandMap | CommandDelay | CommandFilter)
        return IN_THE_LOOP if inside else _to_do("MuJoCo has no such part", effect)
    if drive.servo and added.keys() & {"lag", "delay", "limit"}:
        return IN_THE_LOOP
    if drive.is_dc_motor and "lag" in added:
        return _to_do("MuJoCo's DC motor takes its voltage without a lag", effect)
    return ""


def _to_do(why: str, effect: type[Effect]) -> str:
    """Why something is left out, and what a user of the model does instead."""
    return "; ".join(filter(None, (why, instead(effect))))
