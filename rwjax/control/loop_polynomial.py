"""Characteristic polynomials of closed loops, affine in the gains: continuous PD and PID control."""

from typing import NamedTuple

import numpy as np

from rwjax.control.transfer import Transfer


class LoopPolynomial(NamedTuple):
    r"""Characteristic polynomial of a closed loop, $p_0 + \sum_g K_g\,p_g$, coefficients highest power first.

    Positive gains restore, whatever the plant's sign. A continuous loop has a polynomial in s, a sampled one in z - 1.

    Attributes:
        base: Coefficients without gains, $p_0$, `(..., n + 1)`.
        gains: Coefficients by each gain, $p_g$, `(..., g, n + 1)`.
    """

    base: np.ndarray
    gains: np.ndarray

    def mapped(self, M: np.ndarray) -> "LoopPolynomial":
        """The loop after a linear map of its coefficients.

        Args:
            M: Matrix of the map [1], `(n + 1, n + 1)`.

        Returns:
            A polynomial of the same order.
        """
        return LoopPolynomial(self.base @ M.T, self.gains @ M.T)

    @property
    def order(self) -> int:
        """Order of the polynomial, n [1]."""
        return self.base.shape[-1] - 1

    def poles(self, *gains: float) -> np.ndarray:
        """Poles of one closed loop: s [1/s], or z - 1 of a sampled one [1].

        Args:
            *gains: One value for each gain, in its unit.

        Returns:
            Roots, complex, `(n,)`.
        """
        return np.roots(self.base + np.asarray(gains) @ self.gains)


def pd_loop(plant: Transfer) -> LoopPolynomial:
    r"""PD control, $u = K_p e + K_d \dot e$.

    Args:
        plant: Transfer function of one plant, or of many.

    Returns:
        The loop with gains `(kp, kd)` in V/rad and V s/rad.

    Source:
        Thesis, chapter 4.
    """
    num = plant.restoring
    return loop_of_rows(plant.den, [num, times_variable(num)])


def pid_loop(plant: Transfer) -> LoopPolynomial:
    r"""PID control, $u = K_p e + K_i \int e + K_d \dot e$.

    Args:
        plant: Transfer function of one plant, or of many.

    Returns:
        The loop with gains `(kp, ki, kd)` in V/rad, V/(rad s) and V s/rad.
    """
    num = plant.restoring
    return loop_of_rows(times_variable(plant.den), [times_variable(num), num, times_variable(num, 2)])


def loop_of_rows(base: np.ndarray, rows: list[np.ndarray]) -> LoopPolynomial:
    """A loop from polynomials of different orders.

    Args:
        base: Coefficients without gains [SI], `(..., n + 1)`.
        rows: Coefficients by each gain [SI], `(..., m + 1)` with any m.

    Returns:
        The loop, all its polynomials filled up with leading zeros to the largest order.
    """
    size = max(p.shape[-1] for p in (base, *rows))
    first, *others = (np.concatenate([np.zeros((*p.shape[:-1], size - p.shape[-1])), p], -1) for p in (base, *rows))
    return LoopPolynomial(first, np.stack(others, -2))


def times_variable(p: np.ndarray, power: int = 1) -> np.ndarray:
    """A polynomial times a power of its variable.

    Args:
        p: Coefficients [SI], highest power first, `(..., n + 1)`.
        power: The power [1].

    Returns:
        Coefficients [SI], `(..., n + 1 + power)`.
    """
    return np.concatenate([p, np.zeros((*p.shape[:-1], power))], -1)
