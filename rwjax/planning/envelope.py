"""Limits of a rig: the largest command, current, rates and travel that are known."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from rwjax.effects.library import BY_NAME
from rwjax.errors import InputError
from rwjax.kinds import GOAL, MOTORED, TURNING, WHEELED
from rwjax.logs.driven import driven_by
from rwjax.rig.model import Pwm, Rig

PULSES_US = (1000.0, 2000.0)
"""Shortest and longest pulse of servos and ESCs [us]."""
ONE_WAY_SHARE = 0.2
"""Share of the voltage that pulses command in one direction, below which they count as none in the other direction."""


class Limit(NamedTuple):
    """An output that may have a limit.

    Attributes:
        words: What it is, in words.
        option: The command line's option for it.
        kinds: Kinds of rig that have it.
    """

    words: str
    option: str
    kinds: tuple[str, ...]


LIMITS = {
    "current_A": Limit("current [A]", "--amps", MOTORED),
    "wheel_rad_s": Limit("rate of the wheel", "--rpm", WHEELED),
    "yaw_rad_s": Limit("rate of the axis [rad/s]", "--rate", TURNING),
    "yaw_rad": Limit("travel of the axis [rad]", "--travel", TURNING),
}
"""Outputs that may have a limit, by name."""


class Envelope(NamedTuple):
    """Limits of a rig within which runs have to stay.

    Attributes:
        volts: Largest command, either way [V, of goals rad].
        limits: Largest size of other outputs [SI] by name (`LIMITS`), infinite where no limit is known. `yaw_rad` is the
            travel from where the first run begins, either way.
        directions: Signs that a command may have [1].
        input: Column of the commands: `voltage_V`, or `goal_rad`.
    """

    volts: float
    limits: dict[str, float]
    directions: tuple[float, ...] = (1.0, -1.0)
    input: str = "voltage_V"

    def largest_share(self, peaks: dict[str, np.ndarray]) -> np.ndarray:
        """The largest share of a limit that experiments use.

        Args:
            peaks: Peaks of the outputs [SI] by name, `(e,)` each.

        Returns:
            Share of the limit that is used most [1], `(e,)`.
        """
        return np.max([peaks[name] / limit for name, limit in self.limits.items()], axis=0)

    @property
    def limits_travel(self) -> bool:
        """Whether the travel of the axis is limited."""
        return "yaw_rad" in self.known

    @property
    def known(self) -> dict[str, float]:
        """The limits that are known [SI], by column of a log."""
        return {self.input: self.volts} | {name: limit for name, limit in self.limits.items() if math.isfinite(limit)}


def envelope(
    rig: Rig, volts: float | None = None, most: Mapping[str, float] | None = None, goal: float | None = None
) -> Envelope:
    """The envelope of a rig, from what is given and what the rig file knows, whichever is less.

    A rig file knows the command's range from `drive.pwm` or `drive.supply`, and both range and travel from effects that limit
    them. A neutral pulse at or near the short end of the pulses' range means an ESC that turns in one direction.

    Args:
        rig: The rig.
        volts: Largest command [V], where it is given.
        most: Largest size of other outputs [SI] by name, of those that are given.
        goal: Largest goal of the rig's servo [rad], where the runs are to be goals.

    Returns:
        The envelope.

    Raises:
        InputError: Where nothing limits the command, for a limit of something that the kind of rig does not have, and for a
            command that cannot drive the rig.
    """
    most = dict(most or {})
    if goal is not None and rig.servo is not None and rig.servo.acts_on == "duty" and "drive.supply" not in rig.numbers:
        raise InputError("a duty needs the supply's voltage; write [drive] supply = 12 (volts; logs do not count here)")
    rig = driven_by(rig, "voltage_V" if goal is None else GOAL)
    for name in most:
        check_has(rig.kind, name)
    effects = [(BY_NAME[name], given) for name, given in rig.effects.items()]
    most["yaw_rad"] = min([most.get("yaw_rad", math.inf), *(e.travel(given) for e, given in effects)])
    limits = {name: most.get(name, math.inf) for name, limit in LIMITS.items() if rig.kind in limit.kinds}
    if goal is not None:
        return Envelope(goal, limits, input=GOAL)
    known = [most_volts for most_volts in (volts, rig.numbers.get("drive.supply")) if most_volts is not None]
    if rig.pwm is not None:
        check_neutral(rig.pwm)
    reach = {1.0: math.inf, -1.0: math.inf} if rig.pwm is None else commanded_volts(rig.pwm)
    directions = tuple(way for way, most_volts in reach.items() if most_volts >= ONE_WAY_SHARE * max(reach.values()))
    known += [reach[way] for way in directions if math.isfinite(reach[way])]
    known += [most_volts for e, given in effects if math.isfinite(most_volts := e.largest_command(given))]
    if not known:
        goals = "; for goals of its servo --goal, such as --goal 45deg" if rig.servo is not None else ""
        raise InputError(f"nothing says how many volts the drive gives; add --volts, such as --volts 12{goals}")
    return Envelope(min(known), limits, directions)


def check_has(kind: str, name: str) -> None:
    """Refuses a limit of something that a kind of rig does not have.

    Args:
        kind: The kind.
        name: The output that the limit is of (`LIMITS`).

    Raises:
        InputError: For such a limit.
    """
    if kind not in (limit := LIMITS[name]).kinds:
        raise InputError(f"{limit.option}: a `{kind}` rig has no {limit.words}; leave the option out")


def check_neutral(pwm: Pwm) -> None:
    """Refuses a neutral pulse beyond which hardly any pulse is left.

    Boards drive no further from neutral, in either direction, than their longest pulse is.

    Args:
        pwm: The pulses of an ESC.

    Raises:
        InputError: For such a neutral pulse.
    """
    shortest, longest = PULSES_US
    if shortest <= pwm.neutral_us and longest - pwm.neutral_us >= ONE_WAY_SHARE * (pwm.neutral_us - shortest):
        return
    none = f"above {longest:g}" if pwm.neutral_us > shortest else f"below {shortest:g}"
    raise InputError(
        f"`drive.pwm.neutral_us` is {pwm.neutral_us:g}, and boards give no pulses {none} us: too few are left; an ESC that "
        f"turns one way has its neutral at {shortest:g} or little more, one that turns both ways about {sum(PULSES_US) / 2.0:g}"
    )


def commanded_volts(pwm: Pwm) -> dict[float, float]:
    """The largest command of either sign that the pulses of an ESC can tell.

    Args:
        pwm: The pulses of the ESC.

    Returns:
        Size of the command [V] by its sign; 0 where the ESC does not turn that way.
    """
    shortest, longest = ((end - pwm.neutral_us) * pwm.volts_per_us for end in PULSES_US)
    return {1.0: max(shortest, longest, 0.0), -1.0: max(-shortest, -longest, 0.0)}


def rad_and_degrees(travel: float) -> str:
    """A travel of the axis in words, in rad and in degrees.

    Args:
        travel: The travel [rad].

    Returns:
        The words.
    """
    return f"{travel:g} rad ({math.degrees(travel):.4g}°; a linear axis: {travel:g} m)"
