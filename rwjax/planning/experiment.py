"""An experiment: a command of one of five kinds, as the testbed's board plays it and as any other driver may from a table."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

TICK_HZ = 100
REST_S = 0.6
"""Without command before every experiment: a log's first 0.5 s tell where it starts."""
TONES = (1, 3, 5, 8, 13, 21)  # harmonics of a multisine's period, equally strong
WAVE_SAMPLES = 256  # of a multisine in one period
STAIRS = 8  # steps of a staircase from one end to the other


def wave() -> Int[np.ndarray, " s"]:
    """One period of the multisine, -127 to 127; phases by Schroeder (IEEE Trans. Inf. Theory 16, 1970), which keep the peak
    low."""
    n = np.arange(WAVE_SAMPLES)
    phases = [-np.pi * k * (k + 1) / len(TONES) for k in range(len(TONES))]
    tones = (np.sin(2 * np.pi * tone * n / WAVE_SAMPLES + phase) for tone, phase in zip(TONES, phases, strict=True))
    sum_ = np.sum(list(tones), axis=0)
    return np.rint(127 * sum_ / np.max(np.abs(sum_))).astype(int)


def _stairs(phase: np.ndarray, period: int) -> np.ndarray:
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
    """Volts and seconds, as the rig file understands them."""

    kind: str  # of `SHAPES`
    amplitude: float  # V
    offset: float  # V
    period: float  # s; coast-down: of drive before the wheel runs free
    length: float  # s, after 0.6 s of rest

    def command(self) -> tuple[Float[np.ndarray, " t"], Float[np.ndarray, " t"]]:
        """Time [s] and command [V], each held until the next; the last one is 0."""
        rest, period, length = (round(TICK_HZ * seconds) for seconds in (REST_S, self.period, self.length))
        tick = np.arange(length)
        volts = self.offset + self.amplitude * SHAPES[self.kind](tick % period, period)
        if self.kind == "coast-down":
            volts = np.where(tick < period, volts, 0.0)
        return np.arange(rest + length + 1) / TICK_HZ, np.concatenate([np.zeros(rest), volts, np.zeros(1)])

    @property
    def most_volts(self) -> float:
        """The largest command, either way [V]."""
        return abs(self.amplitude) + abs(self.offset)

    @property
    def span(self) -> tuple[float, float]:
        """The least and the greatest command [V], 0 V among them."""
        top, bottom = self.offset + self.amplitude, self.offset - self.amplitude
        ends = (top, 0.0) if self.kind == "coast-down" else (top, bottom, 0.0)
        return min(ends), max(ends)

    def words(self) -> str:
        """For notes and tables."""
        shape = f"{self.kind}, {self.amplitude:g} V about {self.offset:g} V"
        return f"{shape}, period {self.period:g} s, {self.length:g} s"
