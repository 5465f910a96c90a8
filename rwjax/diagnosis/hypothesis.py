"""Hypotheses: sets of missing effects and wrong fixed numbers, and the plants that follow from them."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.effects.library import BY_NAME, included_in, is_outside, models, of_kind, shown_numbers, special_cases
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import Coupling, Supply
from rwjax.fitting.coordinates import Coordinates, coordinates
from rwjax.fitting.scales import scales_for, sizes_of
from rwjax.kinds import SERVO, of_half
from rwjax.logs.log import Log
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig


def _on_one_axis(name: str) -> str:
    """The name that a number of one half of a two-axis rig has on a rig with one axis; any other as it is."""
    found = of_half(name)
    return name if found is None else found[1]


_NUMBER_COORDINATE = {
    "motor.torque_constant": "current",
    "motor.resistance": "current",
    "motor.inductance": "current",
    "motor.friction": "wheel_rate",
    "wheel.inertia": "wheel_rate",
    "drive.gain": "voltage",
    "axis.inertia": "load",
    "motor.inertia": "load",
    "gear.ratio": "load",
    "drive.supply": "voltage",
    **{f"{SERVO}.{name}": "voltage" for name in ("kp", "ki", "kd", "derivative_filter", "error_limit", "limit")},
    "axis.gravity.torque": "yaw",
    "axis.gravity.angle": "yaw",
}
"""What a wrong number's error is a function of; friction terms of the axis: its rate."""
_TICKING = (f"{SERVO}.period", f"{SERVO}.phase")
"""Numbers of a servo that are no candidates: what a period off by a little does looks like a delay."""


def coordinate_of(name: str) -> str:
    """What a part's torque or error is a function of.

    Args:
        name: name of an effect, or `parameter.NAME`.

    Returns:
        The coordinate in the words of `diagnosis.json`.
    """
    if name.startswith("parameter."):
        number = name.removeprefix("parameter.")
        if (effect := number.rpartition(".")[0]) in BY_NAME:
            return BY_NAME[effect].coordinate
        coordinate = _NUMBER_COORDINATE.get(
            _on_one_axis(number), "pitch" if number.startswith("gimbal.") else "yaw_rate"
        )
        return coordinate.replace("yaw", "pitch") if number.startswith("pitch.") else coordinate
    return BY_NAME[name].coordinate


def spoken(name: str) -> str:
    """An effect in words.

    Args:
        name: name of an effect, or `parameter.NAME`.

    Returns:
        The effect's label, or the name of the wrong number.
    """
    if name.startswith("parameter."):
        return f"wrong {name.removeprefix('parameter.')}"
    return BY_NAME[name].label if name in BY_NAME else name


def as_written(name: str) -> str:
    """An effect as sentences name it: by its name, but a law outside the list, which no rig file has, in words.

    Args:
        name: name of an effect, of a law outside the list, or `parameter.NAME`.

    Returns:
        The name, or the law's label.
    """
    return spoken(name) if is_outside(name) else name


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What may be missing in a rig. Two hypotheses with the same names are equal: the order is for the reader alone.

    Attributes:
        names: names as in `diagnosis.json`: effects, and `parameter.NAME` for fixed numbers that are wrong.
    """

    names: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Hypothesis) and {*self.names} == {*other.names}

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

    def plus(self, *names: str) -> "Hypothesis":
        """This hypothesis with further names.

        Args:
            names: the names to add.

        Returns:
            The larger hypothesis.
        """
        merged = dict.fromkeys((*self.names, *names))
        return Hypothesis(tuple(merged))

    def without(self, name: str) -> "Hypothesis":
        """This hypothesis with one name less.

        Args:
            name: the name to drop.

        Returns:
            The smaller hypothesis.
        """
        return Hypothesis(tuple(other for other in self.names if other != name))

    def contains(self, other: "Hypothesis") -> bool:
        """Whether another hypothesis is a special case of this one.

        Args:
            other: the other hypothesis.

        Returns:
            True where its names, or what they are limits of, are among this one's.
        """
        limits = {limit for name in self.effects for limit in special_cases(name)}
        own = {*self.names} | limits
        return {*other.names} <= own and {*other.names} != {*self.names}


NOTHING = Hypothesis()
"""The rig as it is."""


def simplest(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Those hypotheses of which no other is a special case.

    Args:
        hypotheses: any hypotheses.

    Returns:
        Those, in the order given; of two that are each other's special case, as a spring and a bias beside it, both.
    """
    return [e for e in hypotheses if not any(e.contains(o) and not o.contains(e) for o in hypotheses)]


def structure_for(rig: Rig, hypothesis: "Hypothesis") -> Structure:
    """Structure of the rig in which a hypothesis is looked for.

    Args:
        rig: the rig as it is.
        hypothesis: any hypothesis.

    Returns:
        The plant's structure.
    """
    return structure_of(rig).with_effects(*hypothesis.effects)


def logged_outputs(logs: Iterable[Log]) -> frozenset[str]:
    """Names of the outputs that logs hold.

    Args:
        logs: the logs.

    Returns:
        The names.
    """
    return frozenset(name for log in logs for name in log.outputs)


def chosen_names(hypothesis: Hypothesis) -> tuple[str, ...]:
    """Numbers of a hypothesis of which a fit tries the starts alone.

    Args:
        hypothesis: any hypothesis.

    Returns:
        Names of numbers of its effects.
    """
    every = [(e, n, p) for e in hypothesis.effects for n, p in parameters(BY_NAME[e]).items()]
    return tuple(f"{effect}.{number}" for effect, number, known in every if known.role == "choice")


def free_names(rig: Rig, hypothesis: Hypothesis, outputs: Collection[str]) -> tuple[str, ...]:
    """Numbers that a fit of a hypothesis estimates.

    Args:
        rig: the rig as it is.
        hypothesis: any hypothesis.
        outputs: names of the outputs that the logs hold.

    Returns:
        Names of the rig's free numbers, then of the hypothesis's own.
    """
    free = [*rig.free, *hypothesis.numbers]
    held = {*hypothesis.effects, *rig.effects}
    given: set[str] = set()  # included effects whose numbers an effect before has brought
    for effect in (name for name in BY_NAME if name in hypothesis.effects):
        included = included_in(effect)
        modelled = bool(included) and (models(rig.numbers, included) or included in held | given)
        own, shown = parameters(BY_NAME[included]) if included else {}, shown_numbers(effect, outputs)
        free += [
            f"{effect}.{n}"
            for n, p in parameters(BY_NAME[effect]).items()
            if p.fitted and n in shown and not (modelled and n in own)
        ]
        given.add(included)
    return tuple(free)


def handed_on(same: Iterable[tuple[str, ...]], wanted: set[str], known: set[str]) -> list[tuple[str, str]]:
    """Numbers whose value is known under another name.

    Args:
        same: groups of names of numbers that are the same thing.
        wanted: names of the numbers to find.
        known: names of the numbers with known values.

    Returns:
        Each wanted number that is the same thing as a known one, with the known one.
    """
    found = []
    for names in same:
        other = next((name for name in names if name in known), None)
        found += [(name, other) for name in names if name in wanted and other is not None]
    return found


def candidates(rig: Rig) -> tuple[str, ...]:
    """Every single name that might explain a gap of a rig.

    Args:
        rig: the rig as it is.

    Returns:
        Names of effects in the order of the library, then `parameter.NAME` for each fixed number, of the plant and of the rig's own effects.
    """
    structure = structure_of(rig)
    acting = [
        name
        for name in of_kind(rig.kind)
        if not (rig.driven.supplied and issubclass(BY_NAME[name], Supply))  # the logs say how far the supply drops
        and not (BY_NAME[name].needs_servo and structure.servo is None)
    ]
    found = [
        name
        for name in acting
        if name not in rig.effects
        and not models(rig.numbers, name)
        and not (issubclass(BY_NAME[name], Coupling) and any(issubclass(BY_NAME[e], Coupling) for e in rig.effects))
    ]
    of_plant = [name for name in structure.numbers if rig.numbers.get(name, 0.0) != 0.0]
    of_effects = [
        f"{effect}.{name}"
        for effect, given in rig.effects.items()
        for name, p in parameters(BY_NAME[effect]).items()
        if effect in acting and p.fitted and not p.of_form and given.get(name, p.null) != p.null
    ]
    known = (*rig.free, *rig.tied, *_TICKING)
    return (*found, *(f"parameter.{name}" for name in (*of_plant, *of_effects) if name not in known))


def shown_by(names: Iterable[str], outputs: Collection[str]) -> tuple[str, ...]:
    """Those of some candidates of which logs can show anything.

    Args:
        names: names of effects, and `parameter.NAME`.
        outputs: names of the outputs that the logs hold.

    Returns:
        The names without those all of whose numbers act on outputs that no log holds.
    """

    def shown(name: str) -> bool:
        effect, _, number = name.removeprefix("parameter.").rpartition(".")
        if name in BY_NAME:
            return bool(shown_numbers(name, outputs))
        return effect not in BY_NAME or number in shown_numbers(effect, outputs)

    return tuple(name for name in names if shown(name))


def space(
    rig: Rig, hypothesis: Hypothesis, logs: Sequence[Log], wrong_by: float
) -> tuple[Coordinates, list[np.ndarray]]:
    """Coordinates of a hypothesis's fit, and parameter vectors from which to start it.

    Args:
        rig: the rig as it is.
        hypothesis: any hypothesis.
        logs: the training logs, which tell the sizes of the numbers.
        wrong_by: factor by which a fixed number of the rig file is wrong at most [1].

    Returns:
        The coordinates, and one or more parameter vectors (t,) [SI].
    """
    structure = structure_for(rig, hypothesis)
    names = structure.names
    theta = theta_of(rig, structure)
    bounds = bounds_of(rig, structure)
    free = free_names(rig, hypothesis, logged_outputs(logs))
    size = sizes_of(rig, structure, theta, logs)
    sizes = scales_for(rig, logs)
    options: dict[int, tuple[float, ...]] = {}
    for number in hypothesis.numbers:
        k = names.index(number)
        if bounds[k, 0] > 0.0:
            bounds[k] = max(bounds[k, 0], theta[k] / wrong_by), min(bounds[k, 1], theta[k] * wrong_by)
    for effect in hypothesis.effects:
        for name, p in parameters(BY_NAME[effect]).items():
            k = names.index(f"{effect}.{name}")
            if names[k] in free or not p.fitted:
                options[k] = p.begin(sizes(effect))
        for name, least in BY_NAME[effect].shown_above.items():
            k = names.index(f"{effect}.{name}")
            bounds[k, 0] = min(max(bounds[k, 0], sizes(effect)[least]), bounds[k, 1])
            options[k] = tuple(max(value, bounds[k, 0]) for value in options.get(k, ()))
    count = max((len(values) for values in options.values()), default=1)
    starts = []
    for j in range(count):
        start = theta.copy()
        for k, values in options.items():
            start[k] = values[j % len(values)]
        starts.append(start)
    starts = [start for start in starts if np.any(start != theta)] or starts[:1]  # what no log shows begins nowhere
    starts = list({tuple(start): start for start in starts}.values())  # several may lie at one bound
    mask = np.array([name in free for name in names])
    return coordinates(theta, mask, bounds, size), starts
