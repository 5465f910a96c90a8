"""Wheels that are rings: mass, inertia, and the time of a slew without friction (thesis, chapter 2)."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

ALUMINIUM = 2700.0
"""Density of aluminium [kg/m³]."""


class Ring(NamedTuple):
    """A wheel that is a ring, or many of them: arrays that broadcast.

    Attributes:
        outer: Outer radius [m], `(...)`.
        inner: Inner radius [m], `(...)`.
        thickness: Thickness [m], `(...)`.
        density: Density [kg/m³].
    """

    outer: Float[np.ndarray, "..."] | float
    inner: Float[np.ndarray, "..."] | float
    thickness: Float[np.ndarray, "..."] | float
    density: float = ALUMINIUM

    @property
    def mass(self) -> Float[np.ndarray, "..."] | float:
        """Mass [kg]: rho pi (R² - r²) d (thesis eq. 2.4 to 2.6)."""
        return self.density * np.pi * (np.square(self.outer) - np.square(self.inner)) * self.thickness

    @property
    def inertia(self) -> Float[np.ndarray, "..."] | float:
        """Moment of inertia [kg m²]: m (R² + r²)/2."""
        return 0.5 * self.mass * (np.square(self.outer) + np.square(self.inner))

    @property
    def thin_inertia(self) -> Float[np.ndarray, "..."] | float:
        """Moment of inertia of thesis eq. 2.7 [kg m²], m R²: as if all mass lay at the rim."""
        return self.mass * np.square(self.outer)


def slew_time(I: float, angle: float, momentum: Float[np.ndarray, "..."] | float) -> Float[np.ndarray, "..."] | float:
    r"""Time of a slew without friction [s], $2 I \theta / h$.

    The wheel speeds up over half of it and slows down over the other half.

    Args:
        I: Inertia of the axis [kg m²].
        angle: Angle to turn [rad].
        momentum: Largest momentum of the wheel, h [N m s], `(...)`.

    Returns:
        Time [s], `(...)`.

    Source:
        Thesis, eq. 2.3.
    """
    return 2.0 * I * abs(angle) / momentum
