"""Where the region of stabilising PD gains ends: the curves of the D-partition."""

import numpy as np
from jaxtyping import Float

from rwjax.control.transfer import Transfer


def boundary(plant: Transfer, omega: Float[np.ndarray, " f"], sigma: float = 0.0) -> Float[np.ndarray, "2 f"]:
    r"""PD gains at which a pair of poles crosses $-\sigma \pm j\omega$.

    $K_p + K_d s = -\mathrm{den}(s)/\mathrm{num}(s)$ at $s = -\sigma + j\omega$.

    Args:
        plant: Transfer function of one plant.
        omega: Frequencies along the curve [rad/s], `(f,)`.
        sigma: Distance of the poles from the imaginary axis [1/s].

    Returns:
        `kp` [V/rad] and `kd` [V s/rad], `(2, f)`.

    Source:
        Neimark (1948), D-partition.
    """
    q = _law_at(plant, -sigma + 1j * np.asarray(omega))
    kd = np.imag(q) / omega
    return np.array([np.real(q) + sigma * kd, kd])


def real_boundary(plant: Transfer, kd: Float[np.ndarray, " d"], sigma: float = 0.0) -> Float[np.ndarray, " d"]:
    r"""Proportional gains at which a real pole crosses $-\sigma$: the straight line of the D-partition.

    Args:
        plant: Transfer function of one plant.
        kd: Derivative gains [V s/rad], `(d,)`.
        sigma: Distance of the pole from the imaginary axis [1/s].

    Returns:
        `kp` [V/rad], `(d,)`; no number where the plant has a zero at $-\sigma$.
    """
    return np.real(_law_at(plant, np.array([-sigma + 0j]))) + sigma * np.asarray(kd)


def _law_at(plant: Transfer, s: np.ndarray) -> np.ndarray:
    """What the control law has to be at s for a pole there [V/rad]."""
    num = np.polyval(plant.restoring, s)
    nowhere = np.full(num.shape, np.nan, complex)  # no gain moves a pole to a zero
    return np.divide(-np.polyval(plant.den, s), num, out=nowhere, where=num != 0.0)
