"""Feed-forward of friction and of a dead zone as a C header, for a controller's firmware."""

import re
from typing import NamedTuple

from rwjax.effects.c_code import bell, literal
from rwjax.effects.library import BY_NAME, of_kind
from rwjax.errors import RigError
from rwjax.export import Exported
from rwjax.export.template import rendered
from rwjax.rig.model import Rig

TEMPLATE = "feed_forward.h.j2"


class Term(NamedTuple):
    """A term of the friction's level while the axis slides.

    Attributes:
        value: The term, a C expression of the rate's size `w` and its sign `s`.
        meaning: What it is.
    """

    value: str
    meaning: str


def c_header(rig: Rig) -> Exported:
    """Friction over the rate, and the command for a wanted voltage, as C functions in single precision.

    Args:
        rig: A rig with one axis.

    Returns:
        The header, and which effects a feed-forward by the rate and the voltage alone cannot hold.

    Raises:
        RigError: For a rig without an axis or with two of them.
    """
    if rig.kind in ("wheel", "two_axis"):
        raise RigError(f"`{rig.name}`: kind `{rig.kind}` has no friction of one axis to feed forward")
    order = [name for name in of_kind(rig.kind) if name in rig.effects]
    steps = [(name, text) for name in reversed(order) if (text := BY_NAME[name].c_command(rig.effects[name]))]
    levels = [Term(text, name) for name in order if (text := BY_NAME[name].c_level(rig.effects[name]))]
    held = {*(name for name, _ in steps), *(term.meaning for term in levels)}
    left_out = {name: "it is no function of the rate or of the command alone" for name in order if name not in held}
    text = rendered(
        TEMPLATE,
        rig=rig,
        prefix=_identifier(rig.name),
        terms=[*_terms(rig), *levels],
        steps=steps,
        volts_per_torque=_volts_per_torque(rig),
        number=literal,
    )
    return Exported(text, left_out)


def _identifier(name: str) -> str:
    """A name as a C identifier."""
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_").lower()
    return f"rig_{word}" if not word or word[0].isdigit() else word


def _terms(rig: Rig) -> list[Term]:
    """The terms of the friction that the rig file models by its own numbers."""
    known, found = rig.numbers, list[Term]()
    if "axis.friction.viscous" in known:
        found.append(Term(f"{literal(known['axis.friction.viscous'])} * w", "axis.friction.viscous"))
    if "axis.friction.coulomb" in known:
        found.append(Term(literal(known["axis.friction.coulomb"]), "axis.friction.coulomb"))
    if "axis.friction.static" in known:
        peak = known["axis.friction.static"] - known.get("axis.friction.coulomb", 0.0)
        found.append(Term(bell(peak, known["axis.friction.stribeck_velocity"], 2.0), "axis.friction.static"))
    if "axis.friction.b3" in known:
        b3, b2, b1, b0 = (literal(known[f"axis.friction.{b}"]) for b in ("b3", "b2", "b1", "b0"))
        found.append(Term(f"{b3} + w * ({b2} + w * ({b1} + w * {b0}))", "axis.friction.polynomial"))
    return found


def _volts_per_torque(rig: Rig) -> float | None:
    """Voltage for a torque at the axis while the motor does not turn [V/(N m)]; None where the rig file does not say."""
    if rig.kind == "platform":
        return 1.0 / rig.numbers["drive.gain"]
    known = rig.numbers
    if not {"motor.torque_constant", "motor.resistance"} <= known.keys():
        return None
    way = -1.0 if rig.kind == "reaction" else 1.0
    return way * known["motor.resistance"] / (known["motor.torque_constant"] * known.get("gear.ratio", 1.0))
