"""All effects by name, in the order of tables, reports and docs."""

from collections.abc import Collection, Iterable
from types import ModuleType

from rwjax.effects import axis, axis_friction, drive, motor, sensor, two_axis, unlisted, wheel
from rwjax.effects.effect import Effect, FittedRig
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import Dry
from rwjax.effects.rig_terms import LEVELS_IN_RIG
from rwjax.kinds import NUMBERS, SUBSYSTEMS, TWO_AXIS, half_column, of_half


def _defined_in(module: ModuleType) -> list[type[Effect]]:
    """The effects that a module defines, in their order."""
    here = (c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module.__name__)
    return [c for c in here if issubclass(c, Effect) and "name" in vars(c)]


EFFECTS: tuple[type[Effect], ...] = tuple(
    effect for module in (axis_friction, axis, wheel, motor, drive, sensor) for effect in _defined_in(module)
)
"""The effects of rigs with one axis: every class of these modules, in the order in which it is defined."""
ON_TWO_AXES: tuple[type[Effect], ...] = (*two_axis.on_each_half(EFFECTS), *_defined_in(two_axis))
"""What a two-axis rig has: the effects above on each of its halves, and what only it can have."""
_UNLISTED = _defined_in(unlisted)
UNLISTED: tuple[type[Effect], ...] = (*_UNLISTED, *two_axis.on_each_half(_UNLISTED))
"""Laws outside the list of effects, for one axis and for each half of two (`Effect.passes_for`)."""
LIBRARY: tuple[type[Effect], ...] = (*EFFECTS, *ON_TWO_AXES, *UNLISTED)
"""Everything above."""
BY_NAME: dict[str, type[Effect]] = {effect.name: effect for effect in LIBRARY}
"""Every effect that plants and fits know, those registered from outside the library last."""


def listed() -> dict[str, type[Effect]]:
    """The effects that rig files and answers may name.

    Returns:
        The effects by name, in the order of the library, without the laws outside the list.
    """
    return {name: effect for name, effect in BY_NAME.items() if not effect.passes_for}


def of_kind(kind: str) -> dict[str, type[Effect]]:
    """The effects that a kind of rig may have.

    Args:
        kind: Kind of the rig.

    Returns:
        The effects by name, in the order of the library.
    """
    if kind in TWO_AXIS:
        return {name: e for name, e in listed().items() if e in ON_TWO_AXES or issubclass(e, two_axis.OF_THE_LOG)}
    return {
        name: e for name, e in listed().items() if e not in ON_TWO_AXES and kind in SUBSYSTEMS[name.partition(".")[0]]
    }


def is_outside(name: str) -> bool:
    """Whether a name is that of a law outside the list of effects, which no rig file has and no answer claims.

    Args:
        name: Any name.

    Returns:
        True or False.
    """
    return name in BY_NAME and bool(BY_NAME[name].passes_for)


def passing_for(name: str) -> tuple[str, ...]:
    """Names of the laws outside the list of effects that pass for an effect.

    Args:
        name: Name of an effect.

    Returns:
        The names.
    """
    return tuple(law.name for law in BY_NAME.values() if name in law.passes_for)


def null_of_optional(number: str) -> float | None:
    """Null of a number that a rig file may leave out since it belongs to the form of an effect.

    Args:
        number: Name of a number, `effect.parameter` for an effect's.

    Returns:
        The null [the number's unit]; None for every other number.
    """
    effect, _, name = number.rpartition(".")
    found = parameters(BY_NAME[effect])[name] if effect in BY_NAME else None
    return found.null if found is not None and found.of_form else None


def unit_of_number(number: str) -> str:
    """SI unit of a number of the rig file or of an effect.

    Args:
        number: Name of the number.

    Returns:
        The unit as text, "" where the number has none.
    """
    effect, _, name = number.rpartition(".")
    unit = parameters(BY_NAME[effect])[name].unit if effect in BY_NAME else NUMBERS[number].unit
    return "" if unit == "1" else unit


def shown_numbers(name: str, outputs: Collection[str]) -> tuple[str, ...]:
    """The numbers of an effect that logs can show (`Effect.output_of`).

    Args:
        name: Name of the effect.
        outputs: Names of the outputs that the logs hold.

    Returns:
        Names of the numbers.
    """
    effect, half = BY_NAME[name], of_half(name)
    acts_on = {number: half_column(on, half[0]) if half else on for number, on in effect.output_of.items()}
    return tuple(number for number in parameters(effect) if number not in acts_on or acts_on[number] in outputs)


def included_in(name: str) -> str:
    """Name of the effect that another one includes (`Effect.includes`).

    Args:
        name: Name of an effect, or of anything else that a hypothesis may hold.

    Returns:
        The included effect's name, "" where there is none.
    """
    return BY_NAME[name].includes if name in BY_NAME else ""


def special_cases(name: str) -> set[str]:
    """Names that are a special case or a limit of an effect: other effects, the included one among them, and wrong numbers of the rig file.

    Args:
        name: Name of an effect.

    Returns:
        The names.
    """
    effect = BY_NAME[name]
    wrong = {f"parameter.{number}" for number in effect.covers}
    return {*effect.limits, *([effect.includes] if effect.includes else [])} | wrong


def models(numbers: Iterable[str], effect: str) -> bool:
    """Whether a rig file models an effect by one of its own numbers.

    Args:
        numbers: Names of the numbers that the rig file holds.
        effect: Name of the effect.

    Returns:
        True where one of the numbers models it.
    """
    return not {*numbers}.isdisjoint(BY_NAME[effect].modelled_by)


def thresholds(kind: str) -> set[str]:
    """Numbers that are a size of command [V] below which the drive gives nothing (`Effect.threshold`).

    Args:
        kind: Kind of the rig.

    Returns:
        Names `effect.parameter`.
    """
    return {f"{effect.name}.{effect.threshold}" for effect in of_kind(kind).values() if effect.threshold}


def same_groups(fitted: FittedRig) -> list[list[str]]:
    """Effects that are the same thing on a rig, whatever the logs (`Effect.same_as`).

    Args:
        fitted: The rig and its fit.

    Returns:
        Groups of names, in the order of the library.
    """
    groups: list[list[str]] = []
    for name, effect in of_kind(fitted.kind).items():
        for other in effect.same_as(fitted):
            group = next((group for group in groups if name in group or other in group), None)
            if group is None:
                groups.append(group := [])
            group += [new for new in (name, other) if new not in group]
    return groups


def included_numbers() -> list[tuple[str, ...]]:
    """Numbers of the effects that others include, each with the same number of the others (`Effect.includes`).

    Returns:
        Groups of names `effect.parameter` of one and the same number, the included effect's name first.
    """
    return _same((effect.includes, effect) for effect in BY_NAME.values())


def limit_numbers() -> list[tuple[str, ...]]:
    """Numbers of the effects that are limits of others, without including them, each with those of the others.

    Returns:
        Groups of names `effect.parameter` that mean the same thing, the limit's name first.
    """
    return _same((limit, e) for e in BY_NAME.values() for limit in e.limits)


def _same(pairs: Iterable[tuple[str, type[Effect]]]) -> list[tuple[str, ...]]:
    """Groups of the numbers that an effect, given by name, and wider effects have under the same name."""
    groups: dict[str, list[str]] = {}
    for name, wider in pairs:
        for number in parameters(BY_NAME[name]) if name in BY_NAME else ():
            if number in parameters(wider):
                groups.setdefault(f"{name}.{number}", [f"{name}.{number}"]).append(f"{wider.name}.{number}")
    return [tuple(group) for group in groups.values()]


def shown_in(run: str, kind: str) -> tuple[str, ...]:
    """The effects that a kind of run shows (`Effect.shown_by`).

    Args:
        run: Kind of run, a key of `rwjax.effects.shown.RUNS`.
        kind: Kind of the rig.

    Returns:
        Names of the effects of such a rig, in the order of that run's list.
    """
    shown = [effect for effect in of_kind(kind).values() if run in effect.shown_by]
    return tuple(effect.name for effect in sorted(shown, key=lambda effect: effect.shown_by[run]))


def dry_numbers(names: Iterable[str]) -> set[str]:
    """Numbers that give dry friction its level: where one of them is positive, a body may stick.

    Args:
        names: Names of a structure's numbers, those of effects as `effect.parameter`.

    Returns:
        Those of the names that give dry friction a level: torques, or shares of the load.
    """
    levels = {
        f"{effect.name}.{number}"
        for effect in BY_NAME.values()
        if issubclass(effect, Dry)
        for number, known in parameters(effect).items()
        if known.null == known.bounds[0] == 0.0
        and not known.optional  # what may be negative changes a level that others give
    }
    return {name for name in names if name in levels or name in LEVELS_IN_RIG}


def register(effect: type[Effect]) -> None:
    """Makes an effect from outside the library known. Its programs are compiled anew in every process.

    Args:
        effect: The class of the effect.

    Raises:
        ValueError: Its name is taken or begins with no subsystem, or it lacks a method of its port.
    """
    if BY_NAME.get(effect.name, effect) is not effect:
        raise ValueError(f"an effect `{effect.name}` is there already; give {effect.__name__} another name")
    parts = [part for part, kinds in SUBSYSTEMS.items() if kinds != TWO_AXIS]
    if effect.name.partition(".")[0] not in parts:
        raise ValueError(f"`{effect.name}` has to begin with one of {', '.join(f'`{s}.`' for s in parts)}")
    if missing := sorted(getattr(effect, "__abstractmethods__", ())):
        raise ValueError(f"{effect.__name__} lacks {', '.join(missing)}; an effect defines all methods of its port")
    BY_NAME[effect.name] = effect
