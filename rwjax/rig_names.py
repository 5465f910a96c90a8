"""The names of the rig file: every plant number with symbol, unit and sign, and the kinds that hold it."""

from collections.abc import Callable
from typing import NamedTuple

KINDS = ("wheel", "platform", "reaction")
MOTORED, TURNING = (
    ("wheel", "reaction"),
    ("platform", "reaction"),
)  # kinds with a motor and wheel; with an axis
SUBSYSTEMS = {"motor": MOTORED, "wheel": MOTORED, "axis": TURNING, "drive": KINDS, "sensor": KINDS}
THESIS_COLUMNS = ("t", "pos1", "pos2", "speed2", "pwm_1", "pwm_2")

SIGNS: dict[str, Callable[[float], bool]] = {
    "any": lambda value: True,
    "positive": lambda value: value > 0.0,
    "zero or positive": lambda value: value >= 0.0,
    "different from zero": lambda value: value != 0.0,
}


class Number(NamedTuple):
    """What is known of a plant number before any file is read."""

    symbol: str
    unit: str
    sign: str  # a key of SIGNS
    kinds: tuple[str, ...]
    required: bool = False  # an absent one counts as zero: the term is not modelled


POLYNOMIAL = "axis.friction.polynomial"  # in the file; inside it is the four numbers below
COEFFICIENTS = tuple(f"axis.friction.{b}" for b in ("b3", "b2", "b1", "b0"))

NUMBERS = {
    "motor.torque_constant": Number("K", "N m/A", "positive", MOTORED, required=True),
    "motor.resistance": Number("R", "ohm", "positive", MOTORED, required=True),
    "motor.inductance": Number("L", "H", "zero or positive", MOTORED),
    "motor.friction": Number("b", "N m s/rad", "zero or positive", MOTORED),
    "wheel.inertia": Number("J", "kg m2", "positive", MOTORED, required=True),
    "drive.gain": Number("k", "N m/V", "different from zero", ("platform",), required=True),
    "axis.inertia": Number("I", "kg m2", "positive", TURNING, required=True),
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
SETTINGS = {
    "name": KINDS,
    POLYNOMIAL: TURNING,
    "drive.pwm.neutral_us": KINDS,
    "drive.pwm.volts_per_us": KINDS,
    "encoder.counts_per_rev": TURNING,
    "wheel_encoder.counts_per_rev": MOTORED,
    "columns.position": KINDS,
    "columns.pulse": KINDS,
    "fit.free": KINDS,
    "fit.per_run": KINDS,
}
KEYS = {name: n.kinds for name, n in NUMBERS.items() if name not in COEFFICIENTS} | SETTINGS  # key -> kinds
THESIS_CHOICES = {"position": ("pos1", "pos2"), "pulse": ("pwm_1", "pwm_2")}  # for `[columns]`
