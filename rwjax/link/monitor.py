"""The live view of a board: angles, rates, command, battery, losses."""

import math
from collections import deque

from rich.table import Table
from rich.text import Text

from rwjax.errors import printable
from rwjax.link import messages
from rwjax.link.channels import channels
from rwjax.link.messages import Sample
from rwjax.link.session import Session, faults
from rwjax.planning.experiment import TICK_HZ
from rwjax.rig.model import Rig

RATE_TICKS = 10
"""Ticks over which a rate is taken: 0.1 s."""


class View:
    """What the latest samples of a session say.

    Args:
        rig: The rig that hangs on the board.

    Attributes:
        rig: The same.
        lost: Frames of the board that did not arrive whole.
    """

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.lost = 0
        self._samples: deque[Sample] = deque(maxlen=RATE_TICKS + 1)

    def __call__(self, session: Session, sample: Sample) -> None:
        """Takes a sample, as `Session` hands it out.

        Args:
            session: The session that it came in.
            sample: The sample.
        """
        self.lost = session.lost
        self._samples.append(sample)

    @property
    def latest(self) -> Sample | None:
        """The latest sample, None before the first."""
        return self._samples[-1] if self._samples else None

    def angle(self, who: str) -> float | None:
        """The angle of a part.

        Args:
            who: "axis" or "wheel".

        Returns:
            The angle [rad]; None before the first sample, and where the rig has no such encoder.
        """
        return None if self.latest is None else self._radians(who, self._count(who, self.latest))

    def rate(self, who: str) -> float | None:
        """The rate of a part over the last 0.1 s.

        Args:
            who: "axis" or "wheel".

        Returns:
            The rate [rad/s]; None before the second sample, and where the rig has no such encoder.
        """
        if len(self._samples) < 2:
            return None
        first, last = self._samples[0], self._samples[-1]
        moved = (self._count(who, last) - self._count(who, first) + 2**31) % 2**32 - 2**31
        ticks = (last.tick - first.tick) % 2**32
        angle = self._radians(who, moved)
        return None if angle is None or ticks == 0 else angle * TICK_HZ / ticks

    def volts(self) -> float | None:
        """The command that the latest pulse means.

        Returns:
            The command [V]; None before the first sample, and where the rig file has no `drive.pwm`.
        """
        if self.latest is None or self.rig.pwm is None:
            return None
        half_us = (self.latest.pulse_1, self.latest.pulse_2)[channels(self.rig).output]
        return (half_us / 2.0 - self.rig.pwm.neutral_us) * self.rig.pwm.volts_per_us

    def _count(self, who: str, sample: Sample) -> int:
        return (sample.count_1, sample.count_2)[channels(self.rig).encoders.get(who, 0)]

    def _radians(self, who: str, counts: int) -> float | None:
        per_rev = self.rig.counts_per_rev.get(who)
        return None if per_rev is None else 2.0 * math.pi * counts / per_rev


def table(view: View) -> Table:
    """The view as a table for the terminal.

    Args:
        view: What the latest samples say.

    Returns:
        A table of names and values.
    """
    drawn = Table(show_header=False, title=Text(printable(view.rig.name)))
    sample = view.latest
    if sample is None:
        drawn.add_row("waiting for the board", "")
        return drawn
    drawn.add_row("state", messages.STATES[sample.state] + (f": {faults(sample)}" if sample.faults else ""))
    drawn.add_row("time", f"{sample.tick / TICK_HZ:10.2f} s")
    drawn.add_row("command", _said(view.volts(), "V"))
    for who, angle, rate in (("axis", "yaw", "yaw rate"), ("wheel", "wheel angle", "wheel rate")):
        if who in channels(view.rig).encoders:
            drawn.add_row(angle, _said(view.angle(who), "rad"))
            drawn.add_row(rate, _said(view.rate(who), "rad/s"))
    drawn.add_row("battery", _said(sample.battery / 1000.0, "V"))
    drawn.add_row("lost", f"{view.lost} frames here, {sample.dropped} on the board, {sample.damaged} of ours damaged")
    drawn.add_row("ticks missed", f"{sample.missed}")
    return drawn


def _said(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:10.2f} {unit}"
