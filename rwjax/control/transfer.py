"""Transfer functions from command to angle, their coefficients computed without eigenvalues."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from rwjax.control.linear import CANCELS, Linear
from rwjax.errors import InputError


class Transfer(NamedTuple):
    """Minimal realisation from command [V] to angle [rad], of one plant or of many.

    Polynomials in s, highest power first along the last axis.

    Attributes:
        num: Numerator, `(..., m)`.
        den: Denominator, monic, `(..., n)`.
        hidden: Poles [1/s] that no gain moves: 0 of a conserved momentum.
    """

    num: np.ndarray
    den: np.ndarray
    hidden: tuple[float, ...]

    @property
    def restoring(self) -> np.ndarray:
        """Numerator `(..., m)` of the plant whose command turns forward: with it positive gains restore."""
        first = np.argmax(
            self.num != 0.0, axis=-1, keepdims=True
        )  # one of many plants may have fewer zeros than another
        return self.num * np.sign(np.take_along_axis(self.num, first, -1))

    def each(self) -> "list[Transfer]":
        """Many plants one by one.

        Returns:
            A transfer function for each entry of the first axis.
        """
        return [Transfer(num, den, self.hidden) for num, den in zip(self.num, self.den, strict=True)]


def transfer(linear: Linear) -> Transfer:
    r"""Transfer function of linearised plants.

    $\det(sI - A)$ and $C\,\mathrm{adj}(sI - A)\,B$, common powers of s left out.

    Args:
        linear: One linearised plant, or many.

    Returns:
        Numerator and denominator, and the poles at 0 that were left out of both.

    Raises:
        InputError: Where nothing of the numerator stands out from rounding.
    """
    den, size = characteristic(linear.A)
    num = _adjugate(linear.A, linear.B, linear.C, den)
    most = _adjugate(np.abs(linear.A), np.abs(linear.B), np.abs(linear.C), size)
    num, den = (np.where(np.abs(p) > CANCELS * m, p, 0.0) for p, m in ((num, most), (den, size)))
    if not np.all(np.any(num, axis=-1)):
        raise InputError(
            "the rig's numbers are too far apart for a transfer function; leave the inductance, the lag or the coupling out"
        )
    hidden = 0
    while den.shape[-1] > 1 and not (num[..., -1].any() or den[..., -1].any()):
        num, den, hidden = num[..., :-1], den[..., :-1], hidden + 1
    first = int(np.argmax(np.any(num, axis=tuple(range(num.ndim - 1)))))
    return Transfer(num[..., first:], den, (0.0,) * hidden)


def controller_form(plant: Transfer) -> Linear:
    """State space of a transfer function, hidden poles left out, its command turning forward.

    Args:
        plant: Transfer function of one plant, or of many.

    Returns:
        Matrices of the plant, those of many with the same first axis.
    """
    many, n = plant.den.shape[:-1], plant.den.shape[-1] - 1
    A = np.zeros((*many, n, n))
    A[..., 0, :], A[..., 1:, :-1] = -plant.den[..., 1:], np.eye(n - 1)
    C = np.concatenate([np.zeros((*many, n - plant.num.shape[-1])), plant.restoring], -1)
    return Linear(A, np.broadcast_to(np.eye(n)[0], (*many, n)), C)


def characteristic(A: Float[np.ndarray, "... n n"]) -> tuple[np.ndarray, np.ndarray]:
    r"""Characteristic polynomial $\det(sI - A)$ and the size of what its coefficients are summed from.

    Only products and sums, slow states first: numbers of many sizes then do not spoil each other.

    Args:
        A: System matrices [SI], `(..., n, n)`.

    Returns:
        Coefficients [SI], highest power first, `(..., n + 1)`, and for each the sum of the absolute values of its terms,
        `(..., n + 1)`. A coefficient far below that sum is rounding.

    Source:
        Samuelson, Ann. Math. Statist. 13 (1942); Berkowitz, Inf. Process. Lett. 18 (1984).
    """
    slow = np.argsort(np.max(np.abs(np.diagonal(A, axis1=-2, axis2=-1)).reshape(-1, A.shape[-1]), axis=0))
    A = A[..., slow[:, None], slow]
    found = []
    for M, sign in ((A, -1.0), (np.abs(A), 1.0)):
        p = np.ones((*A.shape[:-2], 1))
        for r in range(A.shape[-1]):
            grown = np.concatenate([p, sign * M[..., r, r, None] * p[..., -1:]], -1)
            grown[..., 1:-1] += sign * M[..., r, r, None] * p[..., :-1]
            grown[..., 2:] += sign * _adjugate(M[..., :r, :r], M[..., :r, r], M[..., r, :r], p)
            p = grown
        found.append(p)
    return found[0], found[1]


def _adjugate(A: np.ndarray, B: np.ndarray, C: np.ndarray, den: np.ndarray) -> Float[np.ndarray, "... n"]:
    r"""Coefficients of $C\,\mathrm{adj}(sI - A)\,B$, from `den` $=\det(sI - A)$ and the Markov parameters $C A^k B$."""
    n, found = A.shape[-1], np.zeros_like(B)
    for k in range(n):
        found[..., k:] += np.sum(C * B, -1, keepdims=True) * den[..., : n - k]
        B = np.squeeze(A @ B[..., None], -1)
    return found
