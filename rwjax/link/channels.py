"""Which output and which encoders of a board belong to a rig, and whether the two agree."""

from typing import NamedTuple

from rwjax.errors import RigError
from rwjax.link.messages import Hello
from rwjax.rig.model import Pwm, Rig


class Channels(NamedTuple):
    """Which of a board's two outputs and two encoders, 0 or 1, belong to a rig.

    Attributes:
        output: Index of the output that drives the rig.
        encoders: Index of the encoder of "axis" and "wheel", of those that the rig has and counts.
    """

    output: int
    encoders: dict[str, int]


def channels(rig: Rig) -> Channels:
    """The channels of a rig.

    Encoder 1 and output 1 belong to the axis unless `[columns]` says otherwise. The wheel's encoder is the other one;
    where there is no axis it takes the axis's place.

    Args:
        rig: A rig with one axis.

    Returns:
        Its output and encoders.
    """
    axis = int(rig.columns.get("position", "pos1") == "pos2")
    of = {"axis": axis, "wheel": axis if rig.kind == "wheel" else 1 - axis}
    absent = {"wheel": "axis", "platform": "wheel", "joint": "wheel"}.get(rig.kind)
    encoders = {who: k for who, k in of.items() if who in rig.counts_per_rev and who != absent}
    return Channels(int(rig.columns.get("pulse", "pwm_1") == "pwm_2"), encoders)


def pwm_of(rig: Rig) -> Pwm:
    """The map from pulse width to volts of a rig that is to be recorded.

    Args:
        rig: A rig with one axis.

    Returns:
        Its `drive.pwm`.

    Raises:
        RigError: Where the rig file says nothing about pulses, or nothing about counts.
    """
    if rig.pwm is None:
        raise RigError(
            f"{rig.name}: no `drive.pwm`; a recording needs `pwm = {{ neutral_us = 1500, volts_per_us = … }}`"
        )
    if not rig.counts_per_rev:
        raise RigError(f"{rig.name}: no `counts_per_rev`; a recording needs one under [encoder] or [wheel_encoder]")
    return rig.pwm


def check_board(hello: Hello, rig: Rig) -> list[str]:
    """Compares what a board says of itself with the rig file.

    Args:
        hello: What the board says.
        rig: The rig that hangs on it.

    Returns:
        A remark for every encoder whose resolution differs.

    Raises:
        RigError: Where the board's pulses mean other volts, or the rig file says nothing about pulses or counts.
    """
    pwm = pwm_of(rig)
    if hello.pulse_neutral != 2.0 * pwm.neutral_us:
        raise RigError(
            f"{rig.name}: `neutral_us` is {pwm.neutral_us:g}, and the board's neutral pulse lasts "
            f"{hello.pulse_neutral / 2:g} us; correct the rig file or PULSE_NEUTRAL in the firmware's config.h"
        )
    told = hello.counts_per_rev_1, hello.counts_per_rev_2
    return [
        f"the firmware's config.h has {told[k]} counts a turn for the encoder of the {who}, the rig file "
        f"{rig.counts_per_rev[who]:g}, which is used"
        for who, k in channels(rig).encoders.items()
        if told[k] != rig.counts_per_rev[who]
    ]
