"""Between the rig file and the plant: structure, parameter vector, bounds; and back."""

from dataclasses import replace

import numpy as np

from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.kinds import NUMBERS
from rwjax.plant.one_axis import Structure
from rwjax.rig.model import Rig

ABSENT_IS_ZERO = {
    "wheel": ("motor.friction",),
    "reaction": ("motor.friction",),
    "platform": (),
    "two_axis": ("motor_1.friction", "motor_2.friction"),
}
EVERYTHING = (-np.inf, np.inf)


def structure_of(rig: Rig) -> Structure:
    """What has to be compiled for this rig; an inductance of 0 and absent friction terms are left out."""
    names = {*rig.numbers, *ABSENT_IS_ZERO[rig.kind]}
    names -= {name for name, value in rig.numbers.items() if name.endswith(".inductance") and not value > 0.0}
    inductive = "motor.inductance" in names
    names |= {name.replace("torque", "angle") for name in names if name.endswith(".gravity.torque")}
    numbers = tuple(name for name in NUMBERS if name in names)
    return Structure(rig.kind, numbers, inductive, ()).with_effects(*rig.effects)


def theta_of(rig: Rig, structure: Structure) -> np.ndarray:
    """Parameter vector in the order of `structure.names`; an effect that the rig lacks stands at its null."""
    null = {
        f"{effect}.{name}": p.null for effect in structure.effects for name, p in parameters(BY_NAME[effect]).items()
    }
    return np.array([rig.values.get(name, null.get(name, 0.0)) for name in structure.names])


def bounds_of(rig: Rig, structure: Structure) -> np.ndarray:
    """Lowest and highest value of every number, `(p, 2)`: physical, narrowed by the rig file's `[fit.bounds]`."""
    found = {}
    for name in structure.numbers:
        sign = NUMBERS[name].sign
        nonnegative = sign == "zero or positive" or name.endswith(".friction.viscous")
        low = 1e-12 if sign == "positive" or name.endswith(".inductance") else 0.0 if nonnegative else -np.inf
        found[name] = (min(low, rig.numbers.get(name, low)), np.inf)
    for effect in structure.effects:
        found |= {f"{effect}.{name}": p.bounds for name, p in parameters(BY_NAME[effect]).items()}
    return np.array([rig.bounds.get(name, found[name]) for name in structure.names])


def rig_with(rig: Rig, structure: Structure, theta: np.ndarray, standard_error: dict[str, float]) -> Rig:
    """The rig file with estimates in place, the structure's effects added and standard errors noted."""
    values = dict(zip(structure.names, (float(v) for v in theta), strict=True))
    numbers = {name: values.get(name, old) for name, old in rig.numbers.items()}
    effects = {
        effect: {name: values[f"{effect}.{name}"] for name in parameters(BY_NAME[effect])}
        for effect in structure.effects
    }
    return replace(rig, numbers=numbers, effects=effects, standard_error=dict(standard_error))
