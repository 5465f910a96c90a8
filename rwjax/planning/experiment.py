"""An experiment: a command of one of five kinds, as the testbed's board plays it and as any other driver may from a table.

A command is a voltage, or the goal of a servo. What coasts after a goal has its torque off.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from rwjax.kinds import GOAL
from rwjax.rig.columns import unit_of

TICK_HZ = 100
"""Rate at which the board gives commands [Hz]."""
REST_S = 0.6
"""Time without command before every experiment [s]: a log's first 0.5 s tell where it starts."""
TONES = (1, 3, 5, 8, 13, 21)
"""Harmonics of a multisine's period, equally strong."""
WAVE_SAMPLES = 256
"""Samples of a multisine in one period."""
STAIRS = 8
"""Steps of a staircase from one end to the other."""


def wave() -> Int[np.ndarray, " s"]:
    """One period of the multisine, its phases chosen to keep the peak low.

    Returns:
        Samples from -127 to 127 [1], `(WAVE_SAMPLES,)`.

    Source:
        Schroeder, IEEE Trans. Inf. Theory 16 (1970).
    """
    n = np.arange(WAVE_SAMPLES)
    phases = [-np.pi * k * (k + 1) / len(TONES) for k in range(len(TONES))]
    tones = (np.sin(2 * np.pi * tone * n / WAVE_SAMPLES + phase) for tone, phase in zip(TONES, phases, strict=True))
    total = np.sum(list(tones), axis=0)
    return np.rint(127 * total / np.max(np.abs(total))).astype(int)


def _stairs(phase: np.ndarray, period: int) -> np.ndarray:
    """The staircase up and down, of amplitude 1, at ticks within a period of so many ticks."""
    step = 2 * STAIRS * phase // period
    return 2.0 * np.minimum(step, 2 * STAIRS - step) / STAIRS - 1.0


SHAPES: dict[str, Callable[[np.ndarray, int], np.ndarray]] = {
    "coast-down": lambda phase, period: np.ones(len(phase)),  # then nothing: see `Experiment.command`
    "square": lambda phase, period: np.where(phase < period // 2, 1.0, -1.0),
    "triangle": lambda phase, period: 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * phase / period)),
    "staircase": _stairs,
    "multisine": lambda phase, period: wave()[WAVE_SAMPLES * phase // period] / 127.0,
}
"""Every kind's command of amplitude 1 at ticks within a period of so many ticks; the same as `firmware/rwbed/experiment.c`,
the order too."""


@dataclass(frozen=True)
class Experiment:
    """A command of one kind, in volts as the rig file understands them, or in rad as a goal of its servo.

    Attributes:
        kind: Kind of the command (`SHAPES`).
        amplitude: Amplitude [V, of a goal rad].
        offset: Offset [V, of a goal rad].
        period: Period [s]; of a coast-down the time of drive before the wheel runs free.
        length: Length [s], after `REST_S` of rest.
        input: Column of the command: `voltage_V`, or `goal_rad`.
    """

    kind: str
    amplitude: float
    offset: float
    period: float
    length: float
    input: str = "voltage_V"

    def command(self) -> tuple[Float[np.ndarray, " t"], Float[np.ndarray, " t"]]:
        """The command as a table.

        Returns:
            Time [s] and command [V, of a goal rad], `(t,)` each; each value is held until the next, and the last one is 0.
        """
        rest, period, length = (round(TICK_HZ * seconds) for seconds in (REST_S, self.period, self.length))
        tick = np.arange(length)
        volts = self.offset + self.amplitude * SHAPES[self.kind](tick % period, period)
        if self.kind == "coast-down":
            volts = np.where(tick < period, volts, 0.0)
        return np.arange(rest + length + 1) / TICK_HZ, np.concatenate([np.zeros(rest), volts, np.zeros(1)])

    @property
    def switches(self) -> bool:
        """Whether torque goes off: a servo that is to let its axis coast lets it go."""
        return self.kind == "coast-down" and self.input == GOAL

    def enabled(self) -> Bool[np.ndarray, " t"]:
        """Whether torque is on, at the times of the command.

        Returns:
            True where it is, `(t,)`.
        """
        time, _ = self.command()
        return (time < REST_S + self.period - 0.5 / TICK_HZ) | (not self.switches)

    @property
    def most_volts(self) -> float:
        """Largest size of the command [V]."""
        return abs(self.amplitude) + abs(self.offset)

    @property
    def span(self) -> tuple[float, float]:
        """Least and greatest command [V], 0 V among them."""
        top, bottom = self.offset + self.amplitude, self.offset - self.amplitude
        ends = (top, 0.0) if self.kind == "coast-down" else (top, bottom, 0.0)
        return min(ends), max(ends)

    def words(self) -> str:
        """The experiment in words, for notes and tables.

        Returns:
            The words.
        """
        unit = unit_of(self.input)
        shape = f"{self.kind}, {self.amplitude:g} {unit} about {self.offset:g} {unit}"
        return f"{shape}, period {self.period:g} s, {self.length:g} s"


def length_in(words: str) -> float | None:
    """The length of an experiment that a note tells.

    Args:
        words: The note, as `Experiment.words` has it.

    Returns:
        Length [s], after `REST_S` of rest; None where the words tell none.
    """
    found = re.search(r", (\d+(?:\.\d+)?) s$", words)
    return float(found[1]) if found else None
