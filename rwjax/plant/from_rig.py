"""Between the rig file and the plant: structure, parameter vector, bounds; and back."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from rwjax.effects.effect import Effect
from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import CommandDelay, EncoderDelay
from rwjax.errors import RigError
from rwjax.kinds import GIVEN, GOAL, NUMBERS, SERVO
from rwjax.plant.structure import LATE_TICKS, ServoStructure, Structure
from rwjax.rig.columns import COLUMNS
from rwjax.rig.model import Rig, Servo
from rwjax.rig.tied import with_constants

ABSENT_IS_ZERO = {
    "wheel": ("motor.friction",),
    "reaction": ("motor.friction",),
    "platform": (),
    "joint": (),
    "two_axis": ("motor_1.friction", "motor_2.friction"),
}
"""Numbers by kind of rig that a plant has in any case, 0 where the rig file leaves them out."""
SMALLEST = 1e-12
"""Lower bound of a number that has to be positive, in its own SI unit."""
NOT_BY = {
    "current": ("motor.resistance", "motor.inductance"),
    "torque": ("motor.resistance", "motor.inductance", "motor.torque_constant"),
}
"""Numbers of the motor that do not act where its current or its torque is given."""
PERIOD_OFF_BY = 1.3
"""Factor by which a servo's period may differ from the rig file's where it is free."""


def structure_of(rig: Rig) -> Structure:
    """What has to be compiled for a rig, as it was driven; an inductance of 0 and absent friction terms are left out.

    Args:
        rig: The rig.

    Returns:
        The structure.
    """
    command = _given(rig)
    names = {*rig.numbers, *ABSENT_IS_ZERO[rig.kind]} - {*NOT_BY.get(command, ())}
    names -= {name for name, value in rig.numbers.items() if name.endswith(".inductance") and not value > 0.0}
    if command != "duty" or rig.driven.supplied:
        names.discard("drive.supply")
    servo = _servo(rig, rig.servo) if rig.servo is not None and rig.driven.by == GOAL else None
    if servo is None:
        names -= {name for name in names if name.startswith(f"{SERVO}.")}
    inductive = "motor.inductance" in names
    names |= {name.replace("torque", "angle") for name in names if name.endswith(".gravity.torque")}
    numbers = tuple(name for name in NUMBERS if name in names)
    found = Structure(
        rig.kind,
        numbers,
        inductive,
        (),
        command=command,
        servo=servo,
        encoder_side=rig.servo.encoder_side if rig.servo is not None else "link",
        switched=rig.driven.switched,
        unsigned=tuple(sorted(COLUMNS[name].output for name, source in rig.sources.items() if source.unsigned)),
    ).with_effects(*rig.effects)
    return found._replace(tied=_tied(rig, found)) if rig.tied else found


def _tied(rig: Rig, structure: Structure) -> tuple[tuple[str, str], ...]:
    """The formulas of numbers that the structure has; what it lacks of the rig's stands in them by its value."""
    constant = {name: value for name, value in rig.values.items() if name not in structure.names}
    held = ((name, formula) for name, formula in rig.tied.items() if name in structure.names)
    return tuple((name, with_constants(formula, constant)) for name, formula in held)


def _given(rig: Rig) -> str:
    """What the drive is given."""
    if rig.driven.by != GOAL:
        return GIVEN[rig.driven.by]
    return rig.servo.acts_on if rig.servo is not None else "voltage"


def _servo(rig: Rig, servo: Servo) -> ServoStructure:
    """The static part of a rig's servo."""
    name = f"{SERVO}.period"
    for effect, given in rig.effects.items():
        if issubclass(cls := BY_NAME[effect], CommandDelay | EncoderDelay):
            numbers = {key: jnp.asarray(value) for key, value in given.items()}
            late, most = float(cls(**numbers).delay()), LATE_TICKS * rig.numbers[name]
            if late > most * (1.0 + 1e-9):
                raise RigError(
                    f"`{effect}` is {late:g} s late; a servo remembers {LATE_TICKS} ticks, {most:g} s: tick less often, by `{name}`"
                )
    moves = name in {*rig.free, *rig.per_run}
    return ServoStructure(servo.damping_on, rig.numbers[name], PERIOD_OFF_BY if moves else 1.0)


def theta_of(rig: Rig, structure: Structure) -> np.ndarray:
    """Parameter vector of a rig.

    Args:
        rig: The rig.
        structure: What the plant is made of; an effect that the rig lacks gets the values at which it is absent.

    Returns:
        Values `(p,)` in the order of `structure.names` [SI].
    """
    null = {
        f"{effect}.{name}": p.null for effect in structure.effects for name, p in parameters(BY_NAME[effect]).items()
    }
    return np.array([rig.values.get(name, null.get(name, 0.0)) for name in structure.names])


def bounds_of(rig: Rig, structure: Structure) -> np.ndarray:
    """Lowest and highest value of every number: physical, narrowed by the rig file's `[fit.bounds]`.

    Args:
        rig: The rig.
        structure: What the plant is made of.

    Returns:
        Bounds `(p, 2)` in the order of `structure.names` [SI].
    """
    found = {}
    for name in structure.numbers:
        sign = NUMBERS[name].sign
        nonnegative = sign == "zero or positive" or name.endswith(".friction.viscous")
        low = SMALLEST if sign == "positive" or name.endswith(".inductance") else 0.0 if nonnegative else -np.inf
        found[name] = (min(low, rig.numbers.get(name, low)), np.inf)
    for effect in structure.effects:
        found |= {f"{effect}.{name}": p.bounds for name, p in parameters(BY_NAME[effect]).items()}
    found |= _bounds_of_servo(rig, structure, found)
    return np.array([_narrowed(name, found[name], rig.bounds) for name in structure.names])


def _bounds_of_servo(
    rig: Rig, structure: Structure, found: dict[str, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    """Bounds of a servo's period, and of delays within its loop."""
    if structure.servo is None:
        return {}
    period, off = rig.numbers[f"{SERVO}.period"], structure.servo.period_off_by
    late = [
        name for name in found if issubclass(BY_NAME.get(name.rpartition(".")[0], Effect), CommandDelay | EncoderDelay)
    ]
    longest = {name: (found[name][0], min(found[name][1], LATE_TICKS * period / off)) for name in late}
    return {f"{SERVO}.period": (period / off, period * off)} | longest


def _narrowed(name: str, physical: tuple[float, float], given: dict[str, tuple[float, float]]) -> tuple[float, float]:
    """Bounds of a number narrowed by those of the rig file; a viscous friction may be negative where the file says so."""
    low, high = given.get(name, physical)
    if name.endswith(".friction.viscous"):
        return low, high
    return max(low, physical[0]), min(high, physical[1])


def rig_with(rig: Rig, structure: Structure, theta: np.ndarray, standard_error: dict[str, float]) -> Rig:
    """Rig with estimates in place, the structure's effects added and standard errors noted.

    Args:
        rig: The rig before.
        structure: What the fitted plant is made of.
        theta: Estimates `(p,)` in the order of `structure.names` [SI].
        standard_error: Standard errors by dotted name [SI].

    Returns:
        The rig after.
    """
    values = dict(zip(structure.names, (float(v) for v in theta), strict=True))
    numbers = {name: values.get(name, old) for name, old in rig.numbers.items()}
    effects = {
        effect: {name: values[f"{effect}.{name}"] for name in parameters(BY_NAME[effect])}
        for effect in structure.effects
    }
    return replace(rig, numbers=numbers, effects=effects).with_values({}).with_standard_errors(standard_error)
