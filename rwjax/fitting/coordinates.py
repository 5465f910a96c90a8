"""Coordinates in which a fit moves: logarithms of strictly positive numbers, others in units of their own size."""

from dataclasses import dataclass

import numpy as np

LARGEST_LOG_STEP = 0.7
"""Largest change of a logarithm in one step [1]: a start that is off by a factor must not overshoot."""
SMALL_LOG_STEP = 0.1
"""Log step below which a number moves in proportion to the step, where there is a prior [1].

Logs may determine some numbers only up to a common factor. In proportion, these stay on the straight line along which
they scale together, and the prior decides.
"""


@dataclass(frozen=True)
class Coordinates:
    """The free numbers of a fit and the coordinates in which they move.

    Attributes:
        index: Entries of `theta` that are free `(k,)`.
        logarithmic: Which of them move in their logarithm `(k,)`.
        size: Unit of the others `(k,)` [SI].
        bounds: Lower and upper bound `(k, 2)` [SI].
        small: Log step below which a number moves in proportion to the step [1].
    """

    index: np.ndarray
    logarithmic: np.ndarray
    size: np.ndarray
    bounds: np.ndarray
    small: float = 0.0

    def without(self, number: int) -> "Coordinates":
        """The same coordinates with one number held.

        Args:
            number: Its entry of `theta`.

        Returns:
            Coordinates of the other free numbers.
        """
        kept = self.index != number
        return Coordinates(self.index[kept], self.logarithmic[kept], self.size[kept], self.bounds[kept], self.small)

    def clip(self, theta: np.ndarray) -> np.ndarray:
        """Parameter vector with its free numbers moved into their bounds.

        Args:
            theta: Parameter vector `(t,)` [SI].

        Returns:
            A copy `(t,)` [SI].
        """
        out = theta.copy()
        out[self.index] = np.clip(out[self.index], *self.bounds.T)
        return out

    def slope(self, theta: np.ndarray) -> np.ndarray:
        """Derivative of the free numbers by their coordinates.

        Args:
            theta: Parameter vector `(t,)` [SI].

        Returns:
            Derivative `(k,)` [SI].
        """
        return np.where(self.logarithmic, theta[self.index], self.size)

    def slope_at(self, theta: np.ndarray) -> np.ndarray:
        """`slope` in the order of all numbers.

        Args:
            theta: Parameter vector `(t,)` [SI].

        Returns:
            Derivative `(t,)` [SI], 1 for numbers that are not free.
        """
        out = np.ones(len(theta))
        out[self.index] = self.slope(theta)
        return out

    def move(self, theta: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Parameter vector after a step, kept within bounds.

        Args:
            theta: Parameter vector `(t,)` [SI].
            step: Step in coordinates `(k,)` [1].

        Returns:
            Parameter vector `(t,)` [SI].
        """
        free = theta[self.index]
        with np.errstate(over="ignore", invalid="ignore"):  # each entry is computed both ways and taken once
            factor = np.where(np.abs(step) < self.small, 1.0 + step, np.exp(step))
            moved = np.where(self.logarithmic, free * factor, free + self.size * step)
        out = theta.copy()
        out[self.index] = np.clip(moved, *self.bounds.T)
        return out

    def shorten(self, step: np.ndarray) -> float:
        """Share of a step that respects the largest log step.

        Args:
            step: Step in coordinates `(k,)` [1].

        Returns:
            The share, at most 1 [1].
        """
        longest = np.max(np.abs(step[self.logarithmic]), initial=0.0)
        return min(1.0, LARGEST_LOG_STEP / longest) if longest > 0.0 else 1.0

    def on_bound(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which free numbers sit on a bound.

        Args:
            theta: Parameter vector `(t,)` [SI].

        Returns:
            Which numbers are on their lower bound `(k,)`, and which on their upper bound `(k,)` [true or false].
        """
        low, high = self.bounds.T
        margin = 1e-9 * np.maximum(np.abs(theta[self.index]), self.size)
        with np.errstate(invalid="ignore"):  # a number without end and a range without one
            return theta[self.index] <= low + margin, theta[self.index] >= high - margin


def coordinates(
    theta: np.ndarray, free: np.ndarray, bounds: np.ndarray, size: np.ndarray, *, prior: bool = False
) -> Coordinates:
    """Coordinates of the free numbers; those with a lower bound above 0 are logarithmic.

    Args:
        theta: Parameter vector `(t,)` [SI].
        free: Which numbers are free `(t,)` [true or false].
        bounds: Lower and upper bound `(t, 2)` [SI].
        size: Typical size `(t,)` [SI].
        prior: Whether any number has a prior.

    Returns:
        The coordinates.
    """
    index = np.flatnonzero(free)
    return Coordinates(
        index=index,
        logarithmic=bounds[index, 0] > 0.0,
        size=size[index],
        bounds=bounds[index],
        small=SMALL_LOG_STEP if prior else 0.0,
    )
