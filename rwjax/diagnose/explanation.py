"""Explanations: sets of missing effects and wrong fixed numbers, and the plants that follow from them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.build import bounds_of, structure_of, theta_of
from rwjax.effects import BY_NAME
from rwjax.effects.ports import Coupling
from rwjax.fit.coordinates import Coordinates, coordinates
from rwjax.fit.scales import scales_for, sizes_of
from rwjax.log import Log
from rwjax.param import parameters
from rwjax.plant import Structure
from rwjax.rig import Rig
from rwjax.rig_names import NUMBERS

WRONG_BY = 4.0
"""A fixed number of the rig file is taken to be wrong by at most this factor."""

DRY_IN_RIG = ("axis.friction.coulomb", "axis.friction.b3")
CONTAINS_COULOMB = ("axis.stribeck", "axis.asymmetric_friction", "axis.presliding")
"""Effects that bring a Coulomb level of their own where nothing else models dry friction."""
LIMITS = dict.fromkeys(CONTAINS_COULOMB, ("axis.coulomb",)) | {
    "axis.friction_drift": ("axis.viscous",),
    "axis.spring": ("axis.bias_torque",),
}
"""Effects of which another is a special case or a limit."""


NUMBER_COORDINATE = {
    "motor.torque_constant": "current",
    "motor.resistance": "current",
    "motor.inductance": "current",
    "motor.friction": "wheel_rate",
    "wheel.inertia": "wheel_rate",
    "drive.gain": "voltage",
    "axis.inertia": "load",
    "axis.gravity.torque": "yaw",
    "axis.gravity.angle": "yaw",
}
"""What a wrong number's error is a function of; friction terms of the axis: its rate."""


def coordinate_of(name: str) -> str:
    """What the part called `name` is a function of, in the words of `diagnosis.json`."""
    if name.startswith("parameter."):
        return NUMBER_COORDINATE.get(name.removeprefix("parameter."), "yaw_rate")
    return BY_NAME[name].coordinate


@dataclass(frozen=True, eq=False)
class Explanation:
    """Names as in `diagnosis.json`: effects, and `parameter.NAME` for fixed numbers that are wrong. Their order is for
    the reader alone."""

    names: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Explanation) and {*self.names} == {*other.names}

    def __hash__(self) -> int:
        return hash(frozenset(self.names))

    @property
    def effects(self) -> tuple[str, ...]:
        """The effects among the names."""
        return tuple(name for name in self.names if not name.startswith("parameter."))

    @property
    def numbers(self) -> tuple[str, ...]:
        """Fixed numbers of the rig file that are freed."""
        return tuple(name.removeprefix("parameter.") for name in self.names if name.startswith("parameter."))

    def plus(self, *names: str) -> "Explanation":
        """This explanation with further names, a Coulomb level only once."""
        merged = dict.fromkeys((*self.names, *names))
        return Explanation(tuple(merged))

    def without(self, name: str) -> "Explanation":
        """This explanation with one name less."""
        return Explanation(tuple(other for other in self.names if other != name))

    def contains(self, other: "Explanation") -> bool:
        """Whether `other` is a special case of this explanation."""
        own = {*self.names} | {limit for name in self.names for limit in LIMITS.get(name, ())}
        return {*other.names} <= own and {*other.names} != {*self.names}


OF_ANY_AXIS = ("axis.friction.viscous", "axis.friction.coulomb", "axis.gravity.torque", "axis.gravity.angle")


def structure_for(rig: Rig, explanation: "Explanation") -> Structure:
    """Structure of the rig in which an explanation is looked for: with all effects of the groups that its effects belong
    to, at their null unless it holds them, and numbers that the rig file may lack at 0, so that few programs serve all
    explanations and rigs."""
    own = structure_of(rig)
    if own.has_axis:
        own = own._replace(numbers=tuple(name for name in NUMBERS if name in {*own.numbers, *OF_ANY_AXIS}))
    groups = {BY_NAME[name].group for name in explanation.effects}
    alike = (name for name in Explanation(candidates(rig)).effects if BY_NAME[name].group in groups)
    return own.with_effects(*alike, *explanation.effects)


def free_names(rig: Rig, explanation: Explanation) -> tuple[str, ...]:
    """Numbers that a fit of this explanation estimates: the rig's free ones and those of the explanation."""
    free = [*rig.free, *explanation.numbers]
    has_level = any(name in rig.numbers for name in DRY_IN_RIG) or "axis.coulomb" in (
        *explanation.effects,
        *rig.effects,
    )
    for effect in (name for name in BY_NAME if name in explanation.effects):
        for name in parameters(BY_NAME[effect]):
            if name == "M_c" and effect in CONTAINS_COULOMB:
                if has_level:
                    continue
                has_level = True
            free.append(f"{effect}.{name}")
    return tuple(free)


def levels(wanted: set[str], known: set[str]) -> list[tuple[str, str]]:
    """Coulomb levels among the `wanted` numbers, each with the one among the `known` that is the same thing."""
    names = [f"{effect}.M_c" for effect in ("axis.coulomb", *CONTAINS_COULOMB)]
    same = next((name for name in names if name in known), None)
    return [(name, same) for name in names if name in wanted and same is not None]


def candidates(rig: Rig) -> tuple[str, ...]:
    """Every single name that might explain a gap of this rig, in the order of the library."""
    structure = structure_of(rig)
    kinds = {"axis": structure.has_axis, "wheel": structure.has_wheel, "motor": structure.has_wheel}
    modelled = {"axis.viscous": ("axis.friction.viscous", "axis.friction.b2"), "axis.coulomb": DRY_IN_RIG}
    modelled["axis.stribeck"] = ("axis.friction.static",)
    found = [
        name
        for name in BY_NAME
        if kinds.get(name.split(".")[0], True)
        and name not in rig.effects
        and not any(number in rig.numbers for number in modelled.get(name, ()))
        and not (issubclass(BY_NAME[name], Coupling) and any(issubclass(BY_NAME[e], Coupling) for e in rig.effects))
    ]
    fixed = [name for name in structure.numbers if name not in rig.free and rig.numbers.get(name, 0.0) != 0.0]
    return (*found, *(f"parameter.{name}" for name in fixed))


def space(rig: Rig, explanation: Explanation, logs: Sequence[Log]) -> tuple[Coordinates, list[np.ndarray]]:
    """Coordinates of an explanation's fit, and parameter vectors from which to start it."""
    structure = structure_for(rig, explanation)
    names = structure.names
    theta = theta_of(rig, structure)
    bounds = bounds_of(rig, structure)
    free = free_names(rig, explanation)
    size = sizes_of(rig, structure, theta, logs)
    sizes = scales_for(rig, logs)
    options: dict[int, tuple[float, ...]] = {}
    for number in explanation.numbers:
        k = names.index(number)
        if bounds[k, 0] > 0.0:
            bounds[k] = max(bounds[k, 0], theta[k] / WRONG_BY), min(bounds[k, 1], theta[k] * WRONG_BY)
    for effect in structure.effects:
        for name, p in parameters(BY_NAME[effect]).items():
            k = names.index(f"{effect}.{name}")
            if effect in explanation.effects and names[k] in free:
                options[k] = p.begin(sizes(effect))
    count = max((len(values) for values in options.values()), default=1)
    starts = []
    for j in range(count):
        start = theta.copy()
        for k, values in options.items():
            start[k] = values[j % len(values)]
        starts.append(start)
    mask = np.array([name in free for name in names])
    return coordinates(theta, mask, bounds, size), starts
