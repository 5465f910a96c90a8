"""The names of the rig file: every plant number with symbol, unit and sign, and the kinds that hold it."""

from collections.abc import Callable
from typing import NamedTuple

ONE_AXIS, TWO_AXIS = ("wheel", "platform", "reaction", "joint"), ("two_axis",)
KINDS = ONE_AXIS + TWO_AXIS
"""All kinds of rig: those with one axis or a wheel alone, then those with two axes."""
WHEELED = ("wheel", "reaction")
"""Kinds of one axis with a motor that turns a wheel."""
MOTORED = (*WHEELED, "joint")
"""Kinds of one axis with a motor."""
TURNING = ("platform", "reaction", "joint")
"""Kinds of one axis whose axis turns; each may have a servo."""
SUBSYSTEMS = {"motor": MOTORED, "wheel": WHEELED, "axis": TURNING, "drive": ONE_AXIS, "sensor": KINDS}
HALVES = (
    {"axis": "yaw", "wheel": "wheel_1", "motor": "motor_1", "drive": "drive_1", "sensor": "sensor_1"},
    {"axis": "pitch", "wheel": "wheel_2", "motor": "motor_2", "drive": "drive_2", "sensor": "sensor_2"},
)
"""Parts of a two-axis rig, each axis with its wheel, by the names that they have in a `reaction` rig."""
SUBSYSTEMS |= {part: TWO_AXIS for half in HALVES for part in half.values()}
"""Kinds of rig by the part with which names of numbers and effects begin."""
HALF_COLUMNS = {
    "yaw": ("yaw", "pitch"),
    **{word: (f"{word}_1", f"{word}_2") for word in ("wheel", "current", "voltage")},
}
"""First word of a column of either half, by its first word in a log of a `reaction` rig."""


def on_half(name: str, half: int) -> str:
    """The name that a part of a `reaction` rig has on one half of a two-axis rig: `yaw.inertia` for `axis.inertia`.

    Args:
        name: Name on a `reaction` rig, or the name of the part alone.
        half: 0 for yaw with its wheel, 1 for pitch with its wheel [1].

    Returns:
        The name on that half.
    """
    part, dot, rest = name.partition(".")
    return f"{HALVES[half][part]}{dot}{rest}"


def of_half(name: str) -> tuple[int, str] | None:
    """Half and name in a `reaction` rig of what belongs to one half of a two-axis rig.

    Args:
        name: Any name of a number, an effect or one of an effect's numbers.

    Returns:
        The half (0 or 1) and the name; None for what belongs to no half.
    """
    part, dot, rest = name.partition(".")
    for k, parts in enumerate(HALVES):
        for base, own in parts.items():
            if own == part:
                return k, f"{base}{dot}{rest}"
    return None


def half_column(name: str, half: int) -> str:
    """The name that a column of a `reaction` rig's log has on one half: `pitch_rad` for `yaw_rad`.

    Args:
        name: Name of the column in a log of a `reaction` rig.
        half: 0 for yaw with its wheel, 1 for pitch with its wheel [1].

    Returns:
        The name of the column.
    """
    word, _, rest = name.partition("_")
    return f"{HALF_COLUMNS[word][half]}_{rest}"


def is_angle(output: str) -> bool:
    """Whether an output is an angle, of which a run may begin at any, and not a rate or a current.

    Args:
        output: Name of the output.

    Returns:
        True for an angle.
    """
    return output.endswith("_rad")


THESIS_COLUMNS = ("t", "pos1", "pos2", "speed2", "pwm_1", "pwm_2")
"""Columns of a log in the layout of the thesis, in their order."""

SIGNS: dict[str, Callable[[float], bool]] = {
    "any": lambda value: True,
    "positive": lambda value: value > 0.0,
    "zero or positive": lambda value: value >= 0.0,
    "different from zero": lambda value: value != 0.0,
}
"""Whether a value has a sign, by the words that say which."""


class Range(NamedTuple):
    """Sizes that a quantity has on any rig, from a wheel of milligrams to a ship.

    Attributes:
        quantity: The quantity in words, with its article.
        least: Smallest size of one that cannot be 0 [the unit that is its key in `RANGES`].
        most: Largest size [the same unit].
    """

    quantity: str
    least: float
    most: float


RANGES = {
    "kg m2": Range("an inertia", 1e-12, 1e12),
    "N m": Range("a torque", 1e-12, 1e12),
    "N m/A": Range("a torque constant", 1e-12, 1e6),
    "N m/V": Range("a drive's gain", 1e-12, 1e12),
    "N m/rad": Range("a stiffness", 1e-12, 1e12),
    "N m/rad3": Range("a stiffness that grows with the angle", 1e-12, 1e12),
    "N m s/rad": Range("a viscous friction", 1e-12, 1e12),
    "N m s2/rad2": Range("a drag", 1e-12, 1e12),
    "N m s3/rad3": Range("a drag with speed cubed", 1e-12, 1e12),
    "ohm": Range("a resistance", 1e-12, 1e12),
    "H": Range("an inductance", 1e-12, 1e6),
    "V": Range("a voltage", 1e-9, 1e6),
    "V/s": Range("a rate of a voltage", 1e-9, 1e12),
    "A": Range("a current", 1e-9, 1e6),
    "rad": Range("an angle", 1e-9, 1e9),
    "rad/s": Range("a rate", 1e-12, 1e6),
    "s": Range("a time", 1e-9, 1e6),
    "1/V": Range("a curvature", 1e-12, 1e6),
    "1/W": Range("a sag", 1e-12, 1e6),
    "1/A2": Range("a saturation", 1e-12, 1e6),
    "1/(A2 s)": Range("a heating", 1e-12, 1e6),
    "1": Range("a number without unit", 1e-9, 1e6),
    "1/rad": Range("a gain of a servo", 1e-9, 1e9),
    "1/(rad s)": Range("an integral gain of a servo", 1e-9, 1e9),
    "s/rad": Range("a rate gain of a servo", 1e-9, 1e9),
    "us": Range("a pulse width", 1e-3, 1e6),
    "V/us": Range("a voltage per pulse width", 1e-9, 1e6),
    "counts": Range("the resolution of an encoder", 1.0, 1e9),
}
"""Ranges by unit. On a linear axis m, kg and N stand for rad, kg m2 and N m, and the same numbers bound them."""
OTHER = Range("a number", 1e-12, 1e12)
"""Range of a unit that is not among `RANGES`, of an effect from outside the library."""
FASTEST_DECAY, FASTEST_GROWTH = 1e6, 10.0
"""Fastest decay of a motion or a current, and fastest growth of a motion by friction that falls with speed, -b/I [1/s].

A time step of 5 ms is exact for decays a little faster than the one. The other is a factor of e in 0.1 s; Stribeck friction that
falls as steeply as on the demo's rig reaches 4 1/s.
"""


def beyond(value: float, unit: str, sign: str = "any") -> str:
    """Why a number lies outside the range of its quantity.

    Args:
        value: A finite number of this sign [unit].
        unit: Its unit, a key of `RANGES`.
        sign: The sign that it has to have, a key of `SIGNS`.

    Returns:
        The range in words, "" where the number lies in it.
    """
    quantity, least, most = RANGES.get(unit, OTHER)
    size, unit = "" if sign == "positive" else " in size", "" if unit == "1" else f" {unit}"
    if not SIGNS[sign](0.0):
        return "" if least <= abs(value) <= most else f"{quantity} lies between {least:g} and {most:g}{unit}{size}"
    low = "0" if sign == "zero or positive" else f"{-most:g}"
    return "" if abs(value) <= most else f"{quantity} lies between {low} and {most:g}{unit}"


class Number(NamedTuple):
    """What is known of a number of the plant before any file is read.

    Attributes:
        symbol: Symbol of the textbook.
        unit: SI unit as text.
        sign: Signs that it may have, a key of `SIGNS`.
        kinds: Kinds of rig that have it.
        required: Kinds whose rig file has to hold it; another one that is absent counts as 0, its term is not modelled.
    """

    symbol: str
    unit: str
    sign: str
    kinds: tuple[str, ...]
    required: tuple[str, ...] = ()


SERVO = "drive.servo"
"""Section of the rig file that describes the loop between a goal and what the drive is given."""
_SERVO = {
    "kp": ("k_p", "1/rad", "any"),
    "ki": ("k_i", "1/(rad s)", "any"),
    "kd": ("k_d", "s/rad", "any"),
    "derivative_filter": ("T_f", "s", "zero or positive"),
    "error_limit": ("e_max", "rad", "positive"),
    "limit": ("u_max", "1", "positive"),
    "period": ("T", "s", "positive"),
    "phase": ("t_0", "s", "any"),
}
"""Symbol, unit and sign of a servo's numbers; gains and limit are in units of what the servo acts on: V, 1, A or N m."""
SERVO_CHOICES = {
    "acts_on": ("voltage", "duty", "current", "torque"),
    "damping_on": ("error", "speed"),
    "encoder_side": ("link", "motor"),
}
"""Settings of a servo that are words, each with its words; the first one where the file says nothing."""
GIVEN = {"voltage_V": "voltage", "duty": "duty", "command_A": "current", "command_Nm": "torque"}
"""What the drive is given, by the column of the command; with a goal the servo says it."""
UNIT_GIVEN = {"voltage": "V", "duty": "1", "current": "A", "torque": "N m"}
"""Unit of what the drive is given."""
GOAL = "goal_rad"
"""Column of a servo's goal."""
POLYNOMIAL = "axis.friction.polynomial"
"""Key of the friction polynomial in the file: a list of the four numbers `COEFFICIENTS`."""
COEFFICIENTS = tuple(f"axis.friction.{b}" for b in ("b3", "b2", "b1", "b0"))

NUMBERS = {
    "motor.torque_constant": Number("K", "N m/A", "positive", MOTORED, required=WHEELED),
    "motor.resistance": Number("R", "ohm", "positive", MOTORED, required=WHEELED),
    "motor.inductance": Number("L", "H", "zero or positive", MOTORED),
    "motor.friction": Number("b", "N m s/rad", "zero or positive", WHEELED),
    "motor.inertia": Number("J", "kg m2", "zero or positive", ("joint",)),
    "gear.ratio": Number("N", "1", "positive", ("joint",)),  # absent: 1
    "wheel.inertia": Number("J", "kg m2", "positive", WHEELED, required=WHEELED),
    "drive.gain": Number("k", "N m/V", "different from zero", ("platform",), required=("platform",)),
    "drive.supply": Number("V_s", "V", "positive", ONE_AXIS),
    **{f"{SERVO}.{name}": Number(symbol, unit, sign, TURNING) for name, (symbol, unit, sign) in _SERVO.items()},
    "axis.inertia": Number("I", "kg m2", "positive", TURNING, required=TURNING),
    "axis.friction.viscous": Number("b", "N m s/rad", "any", TURNING),  # a slope may be negative (`rwjax region`)
    "axis.friction.coulomb": Number("M_c", "N m", "zero or positive", TURNING),
    "axis.friction.static": Number("M_s", "N m", "zero or positive", TURNING),
    "axis.friction.stribeck_velocity": Number("v_s", "rad/s", "positive", TURNING),
    "axis.friction.b3": Number("b3", "N m", "any", TURNING),
    "axis.friction.b2": Number("b2", "N m s/rad", "any", TURNING),
    "axis.friction.b1": Number("b1", "N m s2/rad2", "any", TURNING),
    "axis.friction.b0": Number("b0", "N m s3/rad3", "any", TURNING),
    "axis.gravity.torque": Number("m g l", "N m", "any", TURNING),
    "axis.gravity.angle": Number("angle", "rad", "any", TURNING),
}


def unit_in_servo(name: str, acts_on: str) -> str:
    """Unit of a number; of a servo's gains and its limit by what the servo acts on.

    Args:
        name: Name of the number, one of `NUMBERS`.
        acts_on: What the servo acts on, one of `SERVO_CHOICES`.

    Returns:
        The unit, such as `N m/rad` of `drive.servo.kp` on torque.
    """
    unit, of = NUMBERS[name].unit, UNIT_GIVEN[acts_on]
    if of == "1" or name not in {f"{SERVO}.{gain}" for gain in ("kp", "ki", "kd", "limit")}:
        return unit
    return of if unit == "1" else f"{of}{unit.removeprefix('1')}" if unit.startswith("1/") else f"{of} {unit}"


_GRAVITY = ("axis.gravity.torque", "axis.gravity.angle")  # yaw turns about the vertical
NUMBERS |= {
    on_half(name, k): Number(
        f"{n.symbol}_{k + 1}", n.unit, n.sign, TWO_AXIS, TWO_AXIS if "reaction" in n.required else ()
    )
    for k in range(2)
    for name, n in NUMBERS.items()
    if "reaction" in n.kinds
    and name not in COEFFICIENTS
    and not name.startswith("drive.")
    and (k == 1 or name not in _GRAVITY)
}
NUMBERS |= {
    "gimbal.difference": Number("I_xx - I_zz", "kg m2", "any", TWO_AXIS),
    "gimbal.product_xy": Number("I_xy", "kg m2", "any", TWO_AXIS),
    "gimbal.product_xz": Number("I_xz", "kg m2", "any", TWO_AXIS),
    "gimbal.product_yz": Number("I_yz", "kg m2", "any", TWO_AXIS),
}
"""Every number of the plant by its name in the rig file."""
ENCODERS = {
    "encoder": ("axis", TURNING),
    "wheel_encoder": ("wheel", WHEELED),
    "yaw_encoder": ("axis", TWO_AXIS),
    "pitch_encoder": ("pitch", TWO_AXIS),
    "wheel_1_encoder": ("wheel_1", TWO_AXIS),
    "wheel_2_encoder": ("wheel_2", TWO_AXIS),
}
"""Sections of the rig file that describe an encoder: what it sits on, and the kinds that have it."""


def encoder_section(who: str, kind: str) -> str:
    """Section of the rig file that describes the encoder of a part.

    Args:
        who: The part that carries the encoder, as in `ENCODERS`.
        kind: Kind of the rig.

    Returns:
        Name of the section.
    """
    return next(section for section, (on, kinds) in ENCODERS.items() if on == who and kind in kinds)


SETTINGS = {
    "name": KINDS,
    POLYNOMIAL: TURNING,
    **{f"{SERVO}.{name}": TURNING for name in SERVO_CHOICES},
    "drive.pwm.neutral_us": ONE_AXIS,
    "drive.pwm.volts_per_us": ONE_AXIS,
    **{f"{section}.counts_per_rev": kinds for section, (_, kinds) in ENCODERS.items()},
    "columns.position": ONE_AXIS,
    "columns.pulse": ONE_AXIS,
    "fit.free": KINDS,
    "fit.per_run": KINDS,
}
"""Keys of the rig file that are no numbers of the plant, each with the kinds that have it."""
KEYS = {name: n.kinds for name, n in NUMBERS.items() if name not in COEFFICIENTS} | SETTINGS
"""Keys that a rig file may hold, each with the kinds of rig that have it."""
THESIS_CHOICES = {"position": ("pos1", "pos2"), "pulse": ("pwm_1", "pwm_2")}
"""Values of the section `[columns]`: which columns of the thesis's layout may belong to the axis."""
