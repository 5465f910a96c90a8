"""Which of many gains put every pole of a closed loop where it should be, for one plant or for a share of many.

The characteristic polynomial is affine in the gains, so that one array expression tests all of them (`rwjax.control.polynomials`).
"""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from rwjax.control.loop_polynomial import LoopPolynomial, pd_loop
from rwjax.control.polynomials import disc, hurwitz, shift, within_sector
from rwjax.control.transfer import Transfer
from rwjax.types import Scalar

BLOCK = 5_000
"""Gain pairs that are tested at a time, so that they stay in the cache."""
PLANTS = 20
"""Plants that are tested at a time: the count of a pair is written once for all of them."""
Enters = tuple[tuple[bool, ...], ...]
"""Of every gain, the coefficients that it is part of."""


def stable(
    loop: LoopPolynomial, *gains: Float[np.ndarray, "..."], sigma: float = 0.0, damping: float = 0.0
) -> np.ndarray:
    """Where every pole of a continuous loop lies left of `-sigma` and is damped enough.

    Args:
        loop: The loop of one plant.
        *gains: One array for each gain, in its unit; they broadcast with each other, as the axes of a grid do.
        sigma: Distance of the poles from the imaginary axis [1/s].
        damping: Least damping ratio [1].

    Returns:
        Whether each set of gains does it [1], of the shape to which the gains broadcast.
    """
    moved = loop.mapped(shift(loop.order, sigma))
    found = np.asarray(_stable(_enters(moved), moved.base, moved.gains, gains))
    if damping > 0.0:
        found = found & np.asarray(_damped(_enters(loop), loop.base, loop.gains, gains, damping))
    return np.broadcast_to(found, np.broadcast_shapes(*(np.shape(g) for g in gains)))


def stable_sampled(loop: LoopPolynomial, *gains: Float[np.ndarray, "..."], radius: float = 1.0) -> np.ndarray:
    """Where every pole of a sampled loop lies within a circle about z = 0.

    Args:
        loop: The sampled loop of one plant.
        *gains: One array for each gain, in its unit; they broadcast with each other.
        radius: Radius of the circle [1].

    Returns:
        Whether each set of gains does it [1], of the shape to which the gains broadcast.
    """
    moved = loop.mapped(disc(loop.order, radius))
    found = np.asarray(_stable(_enters(moved), moved.base, moved.gains, gains))
    return np.broadcast_to(found, np.broadcast_shapes(*(np.shape(g) for g in gains)))


def is_stable(loop: LoopPolynomial, *gains: float) -> bool:
    """Whether all poles of a sampled loop lie within the unit circle, by their values.

    Args:
        loop: The sampled loop of one plant.
        *gains: One value for each gain, in its unit.

    Returns:
        True if they do.
    """
    return bool(np.all(np.abs(1.0 + loop.poles(*gains)) < 1.0))


def share_of_plants(
    plants: Transfer, kp: np.ndarray, kd: np.ndarray, sigma: float = 0.0, damping: float = 0.0
) -> Float[np.ndarray, "p d"]:
    """Share of plants [1] that each pair of PD gains stabilises in the continuous loop, as `stable` judges it.

    Args:
        plants: Transfer functions of k plants.
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.
        sigma: Distance of the poles from the imaginary axis [1/s].
        damping: Least damping ratio [1].

    Returns:
        Share of the plants [1], `(p, d)`.
    """
    if damping > 0.0:
        each = (stable(pd_loop(p), kp[:, None], kd[None, :], sigma=sigma, damping=damping) for p in plants.each())
        return sum(each, start=np.zeros((len(kp), len(kd)))) / len(plants.num)
    loop = pd_loop(plants)
    return _share(loop.mapped(shift(loop.order, sigma)), kp, kd)


def share_of_sampled(
    loops: LoopPolynomial, kp: np.ndarray, kd: np.ndarray, radius: float = 1.0
) -> Float[np.ndarray, "p d"]:
    """Share of sampled PD loops [1] all of whose poles lie within a circle about z = 0, for each pair of gains.

    Args:
        loops: Loops of k plants (`stacked_loops`).
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.
        radius: Radius of the circle [1].

    Returns:
        Share of the plants [1], `(p, d)`.
    """
    return _share(loops.mapped(disc(loops.order, radius)), kp, kd)


def _enters(loop: LoopPolynomial) -> Enters:
    """Which coefficients each gain is part of."""
    part = np.any(loop.gains != 0.0, axis=tuple(range(loop.gains.ndim - 2)))
    return tuple(tuple(bool(x) for x in row) for row in part)


def _coefficients(enters: Enters, base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple) -> list:
    """Coefficients, each an array over those gains only that it depends on."""
    parts = [*zip(enters, rows, gains, strict=True)]
    return [base[k] + sum(g * row[k] for part, row, g in parts if part[k]) for k in range(len(base))]


@partial(jax.jit, static_argnums=0)
def _stable(enters: Enters, base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple) -> Bool[Array, "..."]:
    """Whether the polynomial at each set of gains is Hurwitz."""
    return hurwitz(_coefficients(enters, base, rows, gains))


@partial(jax.jit, static_argnums=0)
def _damped(
    enters: Enters, base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple, damping: Scalar | float
) -> Bool[Array, "..."]:
    """Whether all roots at each set of gains have a damping ratio [1]."""
    return within_sector(_coefficients(enters, base, rows, gains), damping)


@partial(jax.jit, static_argnums=0)
def _votes(
    enters: Enters, base: Float[Array, "k t n"], rows: Float[Array, "k t 2 n"], pairs: Float[Array, "b 2 g"]
) -> Int[Array, "b g"]:
    """Number of plants that each pair of gains stabilises, plants in groups and pairs in blocks."""

    def of_block(pair: Float[Array, "2 g"]) -> Int[Array, " g"]:
        def add(found: Int[Array, " g"], plants: tuple) -> tuple[Int[Array, " g"], None]:
            each = zip(*plants, strict=True)
            stable = [hurwitz(_coefficients(enters, base, rows, (pair[0], pair[1]))) for base, rows in each]
            return found + sum(s.astype(found.dtype) for s in stable), None

        return jax.lax.scan(add, jnp.zeros(pair.shape[1], jnp.int32), (base, rows))[0]

    return jax.lax.map(of_block, pairs)


def _share(moved: LoopPolynomial, kp: np.ndarray, kd: np.ndarray) -> Float[np.ndarray, "p d"]:
    """Share of loops whose mapped polynomial is Hurwitz, for each pair of gains."""
    pairs = np.stack(np.meshgrid(kp, kd, indexing="ij")).reshape(2, -1)
    blocks = -(-pairs.shape[1] // BLOCK)
    size = -(-pairs.shape[1] // blocks)
    padded = np.pad(pairs, ((0, 0), (0, blocks * size - pairs.shape[1])), mode="edge")
    base, rows = (_in_groups(x) for x in moved)
    votes = _votes(_enters(moved), base, rows, np.moveaxis(padded.reshape(2, blocks, size), 1, 0))
    count = np.asarray(votes).ravel()[: pairs.shape[1]]
    return count.reshape(len(kp), len(kd)) / len(moved.base)


def _in_groups(of_plants: np.ndarray) -> np.ndarray:
    """Plants in groups of `PLANTS`, the last one filled up with some that nothing stabilises."""
    missing = -len(of_plants) % PLANTS
    filled = np.concatenate([of_plants, np.full((missing, *of_plants.shape[1:]), np.nan)])
    return filled.reshape(-1, PLANTS, *of_plants.shape[1:])
