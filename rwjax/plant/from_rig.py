"""Between the rig file and the plant: structure, parameter vector, bounds; and back."""

from dataclasses import replace

import numpy as np

from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.kinds import NUMBERS
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig

ABSENT_IS_ZERO = {
    "wheel": ("motor.friction",),
    "reaction": ("motor.friction",),
    "platform": (),
    "two_axis": ("motor_1.friction", "motor_2.friction"),
}
"""Numbers by kind of rig that a plant has in any case, 0 where the rig file leaves them out."""
SMALLEST = 1e-12
"""Lower bound of a number that has to be positive, in its own SI unit."""


def structure_of(rig: Rig) -> Structure:
    """What has to be compiled for a rig; an inductance of 0 and absent friction terms are left out.

    Args:
        rig: The rig.

    Returns:
        The structure.
    """
    names = {*rig.numbers, *ABSENT_IS_ZERO[rig.kind]}
    names -= {name for name, value in rig.numbers.items() if name.endswith(".inductance") and not value > 0.0}
    inductive = "motor.inductance" in names
    names |= {name.replace("torque", "angle") for name in names if name.endswith(".gravity.torque")}
    numbers = tuple(name for name in NUMBERS if name in names)
    return Structure(rig.kind, numbers, inductive, ()).with_effects(*rig.effects)


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
    return np.array([_narrowed(name, found[name], rig.bounds) for name in structure.names])


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
    return replace(rig, numbers=numbers, effects=effects, standard_error=dict(standard_error))
