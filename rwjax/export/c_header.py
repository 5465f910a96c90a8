"""Feed-forward of friction and of a dead zone as a C header, for a controller's firmware."""

import re
from typing import NamedTuple

from rwjax.effects.c_code import literal
from rwjax.effects.library import BY_NAME, of_kind
from rwjax.effects.rig_terms import terms_of
from rwjax.errors import RigError
from rwjax.export import Exported
from rwjax.export.instead import AS_JOINT
from rwjax.export.template import rendered
from rwjax.kinds import UNIT_GIVEN
from rwjax.logs.driven import NEEDED
from rwjax.rig.model import Rig

TEMPLATE = "feed_forward.h.j2"


NO_FUNCTION = "no function of the rate or the command is written for it"
NO_DUTY = "its numbers are in volts, and without `drive.supply` no duty is known for them"
"""Why an effect is left out."""


class Term(NamedTuple):
    """A term of the friction's level while the axis slides.

    Attributes:
        value: The term, a C expression of the rate's size `w` and its sign `s`.
        meaning: What it is.
    """

    value: str
    meaning: str


def c_header(rig: Rig) -> Exported:
    """Friction over the rate, and the command for what the drive is to give, as C functions in single precision.

    Args:
        rig: A rig with one axis. A servo's file says by `acts_on` what the drive is given; else it is a voltage.

    Returns:
        The header, and which effects a feed-forward by the rate and the command alone cannot hold.

    Raises:
        RigError: For a rig without an axis or with two of them.
    """
    if rig.kind in ("wheel", "two_axis"):
        more = f"; {AS_JOINT}" if rig.kind == "wheel" else ""
        raise RigError(f"kind `{rig.kind}` has no friction of one axis to feed forward{more}")
    order = [name for name in of_kind(rig.kind) if name in rig.effects]
    steps = [(name, text) for name in reversed(order) if (text := BY_NAME[name].c_command(rig.effects[name]))]
    undone = {name for name, _ in steps}
    if steps and _given(rig) == "duty":
        steps = _in_volts(steps, rig.numbers.get("drive.supply"))
    levels = [Term(text, name) for name in order if (text := BY_NAME[name].c_level(rig.effects[name]))]
    held = {*(name for name, _ in steps), *(term.meaning for term in levels)}
    left = {name: NO_DUTY if name in undone else NO_FUNCTION for name in order if name not in held}
    if lacking := _lacking(rig):
        left[f"{_identifier(rig.name)}_friction_command"] = f"without `{lacking}` no command is known for a torque"
    text = rendered(
        TEMPLATE,
        left=left,
        kind=rig.kind,
        name=re.sub(r"[*/\\]", "_", rig.name),
        prefix=_identifier(rig.name),
        terms=[*_terms(rig), *levels],
        steps=steps,
        unit=UNIT_GIVEN[_given(rig)],
        per_torque=_command_per_torque(rig),
        number=literal,
    )
    return Exported(text, left)


def _in_volts(steps: list[tuple[str, str]], supply: float | None) -> list[tuple[str, str]]:
    """Steps of a drive that act on volts, for a command that is a duty; none without the supply's voltage [V]."""
    if supply is None:
        return []
    volts = literal(supply)
    return [("from a duty to volts", f"u *= {volts};"), *steps, ("from volts to a duty", f"u /= {volts};")]


def _identifier(name: str) -> str:
    """A name as a C identifier."""
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_").lower()
    return f"rig_{word}" if not word or word[0].isdigit() else word


def _terms(rig: Rig) -> list[Term]:
    """The terms of the friction that the rig file models by its own numbers."""
    texts = (effect.c_level(given) for effect, given in terms_of(rig.numbers))
    return [Term(text, "of the rig file") for text in texts if text]


def _given(rig: Rig) -> str:
    """What the drive is given."""
    return rig.servo.acts_on if rig.servo is not None and rig.kind == "joint" else "voltage"


def _lacking(rig: Rig) -> str | None:
    """The first number without which no command is known for a torque; None where the rig file has them all."""
    if rig.kind == "platform":
        return None
    needed = NEEDED[_given(rig)] + (("drive.supply",) if _given(rig) == "duty" else ())
    return next((name for name in needed if name not in rig.numbers), None)


def _command_per_torque(rig: Rig) -> float | None:
    """Command for a torque at the axis while the motor does not turn [unit of the command per N m]; None where the rig file does not say."""
    if _lacking(rig):
        return None
    given, known = _given(rig), rig.numbers
    if rig.kind == "platform":
        return 1.0 / known["drive.gain"]
    if given == "torque":
        return 1.0
    amperes = (-1.0 if rig.kind == "reaction" else 1.0) / (
        known["motor.torque_constant"] * known.get("gear.ratio", 1.0)
    )
    if given == "current":
        return amperes
    volts = amperes * known["motor.resistance"]
    return volts / known["drive.supply"] if given == "duty" else volts
