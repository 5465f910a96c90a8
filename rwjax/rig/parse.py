"""The sections of a rig file that describe the hardware: from TOML values to plain values, each checked."""

import json
import math
from itertools import product
from typing import Any

from rwjax.errors import RigError
from rwjax.kinds import (
    COEFFICIENTS,
    ENCODERS,
    FASTEST_DECAY,
    FASTEST_GROWTH,
    KINDS,
    NUMBERS,
    POLYNOMIAL,
    SERVO,
    SERVO_CHOICES,
    THESIS_CHOICES,
)
from rwjax.rig.document import number, shown
from rwjax.rig.model import Pwm, Servo

PERIOD = 1e-3
"""Time between a servo's ticks where the rig file does not say [s]."""
_TOGETHER = (
    ("friction.static", "friction.stribeck_velocity"),
    ("friction.stribeck_velocity", "friction.static"),
    ("gravity.angle", "gravity.torque"),
)
"""Numbers of an axis of which the first means nothing without the second."""


def kind(leaves: dict[str, Any]) -> str:
    """The kind of rig.

    Args:
        leaves: Values of the file by dotted name; `kind` is removed.

    Returns:
        One of `kinds.KINDS`.

    Raises:
        RigError: Where there is none, or an unknown one.
    """
    found = leaves.pop("kind", None)
    if found not in KINDS:
        said = "no `kind`" if found is None else f"`kind` is {shown(found)}"
        raise RigError(f'{said}; write kind = "wheel", "platform", "reaction", "joint" or "two_axis"')
    return found


def numbers(leaves: dict[str, Any], kind: str) -> dict[str, float]:
    """The plant numbers that a file holds.

    Args:
        leaves: Values of the file by dotted name.
        kind: Kind of the rig.

    Returns:
        Numbers [SI, the unit in `kinds.NUMBERS`] by name; a friction polynomial as its four coefficients.

    Raises:
        RigError: For a number of the wrong sign, one that is missing, and numbers that cannot be together.
    """
    given = {name: leaves[name] for name in NUMBERS if name in leaves}
    if POLYNOMIAL in leaves:
        if other := next((name for name in given if name.startswith("axis.friction.")), None):
            raise RigError(
                f"`{POLYNOMIAL}` is the whole friction, and `{other}` stands beside it; take one of them out"
            )
        coefficients = leaves[POLYNOMIAL]
        if not isinstance(coefficients, list) or len(coefficients) != len(COEFFICIENTS):
            raise RigError(f"`{POLYNOMIAL}` is {shown(coefficients)}; it has to be the four numbers [b3, b2, b1, b0]")
        given |= dict(zip(COEFFICIENTS, coefficients, strict=True))
    checked = {name: number(name, value, NUMBERS[name].sign, NUMBERS[name].unit) for name, value in given.items()}
    _check_together(checked, kind)
    if any(name.startswith(f"{SERVO}.") for name in leaves):
        checked.setdefault(f"{SERVO}.period", PERIOD)
    return checked


def _check_together(numbers: dict[str, float], kind: str) -> None:
    """`RigError` where a number that the kind needs is missing, or one that another number needs."""
    for name, n in NUMBERS.items():
        if kind in n.required and name not in numbers:
            section, _, key = name.rpartition(".")
            missing = f"no `{name}` ({n.symbol}, {n.unit}), which a `{kind}` rig needs"
            raise RigError(f"{missing}; write {key} = … under [{section}]")
    for axis, (key, needed) in product(("axis", "yaw", "pitch"), _TOGETHER):
        name, other = f"{axis}.{key}", f"{axis}.{needed}"
        if name in numbers and other not in numbers:
            raise RigError(f"`{name}` means nothing without `{other}`; give both, or neither")
    _check_growth(numbers)
    _check_decay(numbers)
    if kind == "two_axis":
        _check_inertia(numbers)


def _check_growth(numbers: dict[str, float]) -> None:
    """`RigError` where friction falls with speed so steeply that every motion grows as no rig's does."""
    for axis in ("axis", "yaw", "pitch"):
        name, inertia = f"{axis}.friction.viscous", numbers.get(f"{axis}.inertia", math.inf)
        if (growth := -numbers.get(name, 0.0) / inertia) > FASTEST_GROWTH:
            raise RigError(
                f"`{name}` is {numbers[name]!r}: a motion of this axis would grow by a factor of e every {1.0 / growth:.2g} s; "
                f"friction that falls with speed lies above -{FASTEST_GROWTH:g} times the inertia, here {-FASTEST_GROWTH * inertia:.4g}"
            )


def _check_decay(numbers: dict[str, float]) -> None:
    """`RigError` where a current or a motion settles faster than on any rig, and than a time step resolves."""
    for axis, motor, wheel in (
        ("axis", "motor", "wheel"),
        ("yaw", "motor_1", "wheel_1"),
        ("pitch", "motor_2", "wheel_2"),
    ):
        R, L, J = (numbers.get(key, 0.0) for key in (f"{motor}.resistance", f"{motor}.inductance", f"{wheel}.inertia"))
        K, b = numbers.get(f"{motor}.torque_constant", 0.0), numbers.get(f"{motor}.friction", 0.0)
        N = 0.0 if J or axis != "axis" else numbers.get("gear.ratio", 1.0)
        I = numbers.get(f"{axis}.inertia", 0.0) + N * N * numbers.get(f"{motor}.inertia", 0.0)
        decays = {
            f"R/L of `{motor}`": (R, L),
            f"K²/(R J) of `{motor}` and `{wheel}`": (K * K, R * J),
            f"b/J of `{motor}` and `{wheel}`": (b, J),
            f"K²N²/(R (I + N² J)) of `{motor}`, `gear` and `{axis}`": (N * N * K * K, R * I if N else 0.0),
            f"b/I of `{axis}`": (numbers.get(f"{axis}.friction.viscous", 0.0), I),
        }
        for what, (over, under) in decays.items():
            if under > 0.0 and over > FASTEST_DECAY * under:
                raise RigError(
                    f"{what} is {over / under:.4g} 1/s; it lies below {FASTEST_DECAY:g} 1/s on any rig: check both"
                    + (", or leave the inductance out" if what.startswith("R/L") else "")
                )


def _check_inertia(numbers: dict[str, float]) -> None:
    """`RigError` where the inertia of a two-axis rig is not positive definite at some pitch angle."""
    D, xy, xz, yz = (numbers.get(f"gimbal.{n}", 0.0) for n in ("difference", "product_xy", "product_xz", "product_yz"))
    for degrees in range(-180, 181):
        s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        A, P = numbers["yaw.inertia"] + D * s * s + 2.0 * xz * s * c, xy * s - yz * c
        if A <= 0.0 or A * numbers["pitch.inertia"] <= P * P:
            raise RigError(
                f"`[gimbal]` is too large for `yaw.inertia` and `pitch.inertia`: at a pitch of {degrees} deg the rig would "
                "have no positive inertia; no body has such a tensor, so make its numbers smaller"
            )


def pwm(leaves: dict[str, Any]) -> Pwm | None:
    """The map from pulse width to volts, `drive.pwm`.

    Args:
        leaves: Values of the file by dotted name.

    Returns:
        The map, None where the file holds none.

    Raises:
        RigError: Where half of it is missing, or a number has the wrong sign.
    """
    given = {key: leaves[f"drive.pwm.{key}"] for key in Pwm._fields if f"drive.pwm.{key}" in leaves}
    if not given:
        return None
    if missing := next((key for key in Pwm._fields if key not in given), None):
        raise RigError(f"`drive.pwm` has no `{missing}`; write pwm = {{ neutral_us = 1500, volts_per_us = 0.02 }}")
    known = {"neutral_us": ("positive", "us"), "volts_per_us": ("different from zero", "V/us")}
    return Pwm(**{key: number(f"drive.pwm.{key}", value, *known[key]) for key, value in given.items()})


def servo(leaves: dict[str, Any]) -> Servo | None:
    """What `[drive.servo]` says in words.

    Args:
        leaves: Values of the file by dotted name.

    Returns:
        The words, None where the file holds no servo.

    Raises:
        RigError: Where a word is unknown, or the section lacks what every servo needs.
    """
    if not any(name.startswith(f"{SERVO}.") for name in leaves):
        return None
    found = {}
    for key, words in SERVO_CHOICES.items():
        value = found[key] = leaves.get(f"{SERVO}.{key}", None if key == "acts_on" else words[0])
        if value not in words:
            said = f"no `{SERVO}.{key}`" if value is None else f"`{SERVO}.{key}` is {shown(value)}"
            raise RigError(f"{said}; write {key} = {' or '.join(map(json.dumps, words))} under [{SERVO}]")
    if f"{SERVO}.kp" not in leaves:
        raise RigError(f"no `{SERVO}.kp`, the servo's gain per rad of error; write kp = … under [{SERVO}]")
    return Servo(**found)


def counts_per_rev(leaves: dict[str, Any]) -> dict[str, float]:
    """The resolution of the encoders.

    Args:
        leaves: Values of the file by dotted name.

    Returns:
        Counted edges per turn [1] by what the encoder sits on ("axis", "wheel"), where given.

    Raises:
        RigError: For anything but a positive number of the range that encoders have.
    """
    keys = {f"{section}.counts_per_rev": who for section, (who, _) in ENCODERS.items()}
    return {who: number(key, leaves[key], "positive", "counts") for key, who in keys.items() if key in leaves}


def columns(leaves: dict[str, Any]) -> dict[str, str]:
    """The columns of the thesis's log layout that belong to this rig, `[columns]`.

    Args:
        leaves: Values of the file by dotted name.

    Returns:
        "position" and "pulse" -> name of the column, where given.

    Raises:
        RigError: For a column that the layout does not have.
    """
    given = {key: leaves[f"columns.{key}"] for key in THESIS_CHOICES if f"columns.{key}" in leaves}
    for key, value in given.items():
        if value not in THESIS_CHOICES[key]:
            right = " or ".join(f'"{column}"' for column in THESIS_CHOICES[key])
            raise RigError(f"`columns.{key}` is {shown(value)}; it has to be {right}, a column of the thesis layout")
    return given
