"""A plant that turns as it is told, whatever the pulses: for the limits of the encoders' inputs."""

from collections.abc import Callable

import numpy as np

from firmware.simavr.avr import F_CPU

POINTS = 33  # of a step


class Spin:
    """Both encoders' angles [states] as functions of time [s], which have to start at 0."""

    late = 0.0

    def __init__(self, first: Callable[[np.ndarray], np.ndarray], second: Callable[[np.ndarray], np.ndarray]) -> None:
        self.angles = first, second

    def advance(self, start: int, end: int, width_us: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """See `firmware.simavr.bench.Plant`."""
        cycles = np.linspace(start, end, POINTS)
        return cycles, np.column_stack([angle(cycles / F_CPU) for angle in self.angles])


def still(t: np.ndarray) -> np.ndarray:
    """Does not turn."""
    return np.zeros_like(t)


def _since(t: np.ndarray, end: float) -> np.ndarray:
    """Seconds of turning: from 50 ms, when the board has started, to `end`."""
    return np.clip(t, 0.05, end) - 0.05


def constant(rate: float, end: float = np.inf) -> Callable[[np.ndarray], np.ndarray]:
    """Turns at so many states a second."""
    return lambda t: rate * _since(t, end)


def swinging(rate: float, period: float, end: float = np.inf) -> Callable[[np.ndarray], np.ndarray]:
    """Swings: fastest at `rate`, reversing twice a period [s]."""
    return lambda t: rate * period / (2 * np.pi) * (1.0 - np.cos(2 * np.pi * _since(t, end) / period))
