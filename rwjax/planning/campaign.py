"""The recommended campaign: few runs that together tell most effects apart, as large as a rig's limits allow.

Each run is there for effects that look alike without it: coast-downs, slow triangles through standstill, a staircase to the
limit, multisines of two sizes, repeats for the noise. Squares, a kind of their own, validate.
"""

from dataclasses import replace

import jax.numpy as jnp

from rwjax.effects.library import BY_NAME, shown_in
from rwjax.errors import InputError
from rwjax.kinds import GOAL
from rwjax.planning.amplitude import size_designs
from rwjax.planning.designs import DESIGNS, Design
from rwjax.planning.envelope import LIMITS, Envelope, commanded_volts, rad_and_degrees
from rwjax.planning.files import Run
from rwjax.planning.motion import WAIT_S
from rwjax.planning.sequence import PlayedRun, play_runs
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Rig


def recommend(rig: Rig, within: Envelope) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """The runs for a rig.

    Where travel is limited, the runs keep to it together, played in this order from where the first one begins.

    Args:
        rig: The rig.
        within: Its limits.

    Returns:
        The runs, and remarks on what the rig's limits or its file leave out.

    Raises:
        InputError: Where nothing that the limits allow moves the simulated rig.
    """
    designs = _possible(rig, within)
    found, twins = play_runs(rig, within, size_designs(rig, within, designs))
    runs = [
        run
        for name, played in found.items()
        for run in _runs(name, designs[name], _tells_apart(rig, within, designs[name]), played)
    ]
    if not runs:
        rest = f", or lets it come to rest within {WAIT_S:g} s" if within.limits_travel else ""
        raise InputError(
            f"within these limits ({_in_words(within)}) no run moves the simulated rig{rest}; raise them, or check its numbers"
        )
    missing = [name for name in designs if name not in found and name not in twins]
    remarks = [
        *_left_out(within, missing),
        *_of_twins(twins),
        *_of_the_drive(rig, within),
        *_of_the_duty(rig, within),
        *_of_the_travel(within),
        *_of_the_file(rig),
    ]
    return tuple(runs), tuple(remarks)


def _of_twins(twins: dict[str, str]) -> list[str]:
    """A remark on designs that are left out as they would repeat others."""
    if not twins:
        return []
    named = ", ".join(f"{name} (as {earlier})" for name, earlier in twins.items())
    return [f"left out, since a smaller run hardly moves the simulated rig and they would repeat another one: {named}"]


def _possible(rig: Rig, within: Envelope) -> dict[str, Design]:
    """The designs for a drive that turns both ways; of one that turns one way, those that do not reverse it.

    Where a servo has no torque that could be off, nothing coasts.
    """
    if within.input == GOAL and rig.kind == "platform":
        return {name: design for name, design in DESIGNS.items() if not design.one_way}
    if len(within.directions) == 2:
        return DESIGNS
    direction = within.directions[0]
    forward = {name: design for name, design in DESIGNS.items() if design.one_way and design.direction > 0.0}
    return {name: replace(design, direction=direction) for name, design in forward.items()}


def _in_words(within: Envelope) -> str:
    """The limits that are known, such as "12 V, travel of the axis 0.01 rad"."""
    words = {within.input: "", **{name: f"{limit.words.partition(' [')[0]} " for name, limit in LIMITS.items()}}
    return ", ".join(f"{words[name]}{value:g} {unit_of(name)}" for name, value in within.known.items())


def _tells_apart(rig: Rig, within: Envelope, design: Design) -> tuple[str, ...]:
    """The effects that runs of a design tell apart; those of a servo only where the runs are its goals."""
    names = shown_in(design.shows, rig.kind)
    return tuple(name for name in names if within.input == GOAL or not BY_NAME[name].needs_servo)


def _runs(name: str, design: Design, tells_apart: tuple[str, ...], played: list[PlayedRun]) -> list[Run]:
    """The runs of a design in the plan, those that repeat numbered."""
    names = [name] if design.repeats == 1 else [f"{name}_{number + 1}" for number in range(design.repeats)]
    return [
        Run(each, one.experiment, design.role, design.why, tells_apart, one.reaches, one.angle_range)
        for each, one in zip(names, played, strict=True)
    ]


def _left_out(within: Envelope, missing: list[str]) -> list[str]:
    """A remark on designs that are left out."""
    if not missing:
        return []
    rest = "do not come to rest, " if within.limits_travel else ""
    return [
        f"left out, since within these limits they {rest}hardly move the simulated rig, or one way only: "
        f"{', '.join(missing)}"
    ]


def _of_the_drive(rig: Rig, within: Envelope) -> list[str]:
    """A remark on an ESC that turns one way, or less far one way than the other."""
    if len(within.directions) == 1:
        return [
            "the ESC turns one way (`neutral_us` is at an end of its pulses, or near it): runs that reverse are left out"
        ]
    if rig.pwm is None or within.input == GOAL:
        return []
    volts = commanded_volts(rig.pwm).values()
    if min(volts) < max(volts) and within.volts == min(volts):
        return [
            f"`neutral_us` is {rig.pwm.neutral_us:g}, off the middle of the pulses: the runs keep to the {min(volts):g} V that they "
            "reach both ways"
        ]
    return []


def _of_the_duty(rig: Rig, within: Envelope) -> list[str]:
    """A remark on how a drive that takes a duty plays volts."""
    if "drive.supply" not in rig.numbers or within.input == GOAL:
        return []
    supply = rig.numbers["drive.supply"]
    return [
        f"the commands are volts, up to {within.volts:g} V: a drive that takes a duty gets `voltage_V` / {supply:g} (`drive.supply`)"
    ]


def _of_the_travel(within: Envelope) -> list[str]:
    """A remark on where the axis has to stand, where travel is limited."""
    if not within.limits_travel:
        return []
    return [
        f"the runs keep to {rad_and_degrees(within.limits['yaw_rad'])} either way of where the axis stands when the first one begins: "
        "bring it to the middle of its travel before, and play them in this order"
    ]


def _of_the_file(rig: Rig) -> list[str]:
    """A remark on a rig file without dry friction."""
    structure = structure_of(rig)
    if rig.kind == "wheel" or one_axis_plant_of(structure, jnp.asarray(theta_of(rig, structure))).bodies():
        return []
    return [
        "the rig file holds no dry friction: if the rig sticks, small runs may not move it; plan again from a corrected file"
    ]
