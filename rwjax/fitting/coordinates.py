"""Coordinates in which a fit moves: logarithms of strictly positive numbers, others in units of their own size."""

from dataclasses import dataclass

import numpy as np

LARGEST_LOG_STEP = 0.7
"""Largest change of a logarithm in one step: keeps a start that is off by a factor from overshooting."""
SMALL_LOG_STEP = 0.1
"""Below it, where there is a prior, a number moves in proportion to the step, as the linear ones do: numbers that the logs
only determine up to a common factor then stay on the straight line along which they scale together and the prior decides."""


@dataclass(frozen=True)
class Coordinates:
    """Free numbers `theta[index]` within `bounds` (k, 2); `size`: unit of the linear ones; `small`: log steps below it move
    in proportion."""

    index: np.ndarray
    logarithmic: np.ndarray
    size: np.ndarray
    bounds: np.ndarray
    small: float = 0.0

    def without(self, number: int) -> "Coordinates":
        """The same with `theta[number]` held."""
        kept = self.index != number
        return Coordinates(self.index[kept], self.logarithmic[kept], self.size[kept], self.bounds[kept], self.small)

    def clip(self, theta: np.ndarray) -> np.ndarray:
        """`theta` with its free numbers moved into their bounds."""
        out = theta.copy()
        out[self.index] = np.clip(out[self.index], *self.bounds.T)
        return out

    def slope(self, theta: np.ndarray) -> np.ndarray:
        """Derivative of the free numbers by their coordinates."""
        return np.where(self.logarithmic, theta[self.index], self.size)

    def slope_at(self, theta: np.ndarray) -> np.ndarray:
        """`slope` in the order of all numbers, 1 for those that are not free."""
        out = np.ones(len(theta))
        out[self.index] = self.slope(theta)
        return out

    def move(self, theta: np.ndarray, step: np.ndarray) -> np.ndarray:
        """`theta` after a step in coordinates, kept within bounds."""
        free = theta[self.index]
        with np.errstate(over="ignore", invalid="ignore"):  # each entry is computed both ways and taken once
            factor = np.where(np.abs(step) < self.small, 1.0 + step, np.exp(step))
            moved = np.where(self.logarithmic, free * factor, free + self.size * step)
        out = theta.copy()
        out[self.index] = np.clip(moved, *self.bounds.T)
        return out

    def shorten(self, step: np.ndarray) -> float:
        """Share of a step that respects the largest log step."""
        longest = np.max(np.abs(step[self.logarithmic]), initial=0.0)
        return min(1.0, LARGEST_LOG_STEP / longest) if longest > 0.0 else 1.0

    def on_bound(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which free numbers sit on their lower and on their upper bound."""
        low, high = self.bounds.T
        margin = 1e-9 * np.maximum(np.abs(theta[self.index]), self.size)
        return theta[self.index] <= low + margin, theta[self.index] >= high - margin


def coordinates(
    theta: np.ndarray, free: np.ndarray, bounds: np.ndarray, size: np.ndarray, *, prior: bool = False
) -> Coordinates:
    """Coordinates for the numbers marked in `free` (p,), with `bounds` (p, 2) and typical `size` (p,); `prior`: whether
    any of them has one."""
    index = np.flatnonzero(free)
    return Coordinates(
        index=index,
        logarithmic=bounds[index, 0] > 0.0,
        size=size[index],
        bounds=bounds[index],
        small=SMALL_LOG_STEP if prior else 0.0,
    )
