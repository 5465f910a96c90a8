"""Polynomials whose coefficients run over gains: where their roots lie, without finding them.

Coefficients are given highest power first, each an array that broadcasts with the others. All tests are Hurwitz tests
of a polynomial that was mapped first: half planes by a shift, sectors by turning, circles by a bilinear map.
"""

from collections.abc import Sequence
from functools import cache
from math import comb

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from rwjax.types import Scalar

LONG = 6
"""Number of coefficients above which rows are divided by their pivot, so that they stay in the range of numbers."""
Coefficients = Sequence[Float[Array, "..."]]
"""Coefficients of a polynomial, highest power first."""


def hurwitz(c: Coefficients) -> Bool[Array, "..."]:
    """Whether all roots lie left of the imaginary axis; roots on it do not.

    A short polynomial is tested without a division: what a pivot would divide by is positive wherever the answer is still yes.

    Args:
        c: Coefficients, arrays that broadcast with each other.

    Returns:
        Whether they do, of the shape to which the coefficients broadcast.

    Source:
        Routh (1877).
    """
    c = [x * jnp.sign(c[0]) for x in c]
    found = jnp.ones((), bool)
    above, row = list(c[0::2]), list(c[1::2])
    for x in c:
        found = found & (x > 0.0)
    while len(row) > 1 or (row and len(above) > 1):
        padded = [*row, *[0.0] * (len(above) - len(row))]
        pivot = row[0] if len(c) > LONG else 1.0
        above, row = row, [(row[0] * above[k + 1] - above[0] * padded[k + 1]) / pivot for k in range(len(above) - 1)]
        found = found & (row[0] > 0.0)
    return found


@cache
def shift(order: int, sigma: float) -> np.ndarray:
    r"""Matrix that takes the coefficients of $p(s)$ to those of $p(s - \sigma)$: roots left of $-\sigma$ come left of 0.

    Args:
        order: Order n of the polynomial [1].
        sigma: Distance of the roots from the imaginary axis [1/s].

    Returns:
        The matrix [SI], `(n + 1, n + 1)`.
    """
    M = np.zeros((order + 1, order + 1))
    for k in range(order + 1):  # s^k -> (s - sigma)^k
        for j in range(k + 1):
            M[order - j, order - k] = comb(k, j) * (-sigma) ** (k - j)
    return M


@cache
def disc(order: int, radius: float) -> np.ndarray:
    r"""Matrix that takes $p(z - 1)$ to a polynomial in w, roots with $|z| < \rho$ to roots left of 0.

    $z = \rho\,(1 + w)/(1 - w)$.

    Args:
        order: Order n of the polynomial [1].
        radius: Radius of the circle, $\rho$ [1].

    Returns:
        The matrix [1], `(n + 1, n + 1)`.
    """
    M = np.zeros((order + 1, order + 1))
    upper, lower = np.array([radius + 1.0, radius - 1.0]), np.array([-1.0, 1.0])
    for k in range(order + 1):
        term = np.array([1.0])
        for factor in [upper] * k + [lower] * (order - k):
            term = np.polymul(term, factor)
        M[:, order - k] = np.pad(term, (order + 1 - len(term), 0))
    return M


def mapped(M: np.ndarray, c: Coefficients) -> list[Float[Array, "..."]]:
    """Coefficients after a linear map of them.

    Args:
        M: Matrix of the map [SI], `(m, n)`.
        c: n coefficients [SI], arrays that broadcast with each other.

    Returns:
        m coefficients [SI].
    """
    return [jnp.asarray(sum(m * x for m, x in zip(row, c, strict=True) if m != 0.0)) for row in M]


def within_sector(c: Coefficients, damping: Scalar | float) -> Bool[Array, "..."]:
    r"""Whether all roots have at least a damping ratio $\zeta$.

    Then $p(s e^{j\varphi})\,p(s e^{-j\varphi})$ with $\sin\varphi = \zeta$ is Hurwitz, a real polynomial of twice the order.

    Args:
        c: Coefficients, arrays that broadcast with each other.
        damping: The damping ratio [1].

    Returns:
        Whether they have, of the shape to which the coefficients broadcast.
    """
    turn = jnp.arcsin(damping)
    order = len(c) - 1
    re = [jnp.cos((order - k) * turn) * x for k, x in enumerate(c)]
    im = [jnp.sin((order - k) * turn) * x for k, x in enumerate(c)]
    square = []
    for total in range(2 * order + 1):
        pairs = [(k, total - k) for k in range(order + 1) if 0 <= total - k <= order]
        square.append(sum(re[j] * re[k] + im[j] * im[k] for j, k in pairs))
    return hurwitz(square)
