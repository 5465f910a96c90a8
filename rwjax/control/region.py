"""Gains that stabilise: which of many gain pairs put every pole of the closed loop where it should be.

The characteristic polynomial is affine in the gains, so one array expression tests all of them (`rwjax.control.polynomials`).
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int
from scipy.linalg import expm

from rwjax.control.linear import Transfer, linearised, transfer
from rwjax.control.polynomials import disc, hurwitz, shift, within_sector
from rwjax.errors import InputError
from rwjax.rig.model import Rig
from rwjax.types import Scalar

MOST_LATE = 12


class Loop(NamedTuple):
    r"""Characteristic polynomial of a closed loop, $p_0 + \sum_g K_g\,p_g$, highest power first: `base` (…, n + 1) and one row
    of `gains` (…, g, n + 1) for every gain. Positive gains restore, whatever the plant's sign."""

    base: np.ndarray
    gains: np.ndarray

    def mapped(self, M: np.ndarray) -> "Loop":
        """The loop after a linear map of its coefficients."""
        return Loop(self.base @ M.T, self.gains @ M.T)

    @property
    def order(self) -> int:
        return self.base.shape[-1] - 1

    def poles(self, *gains: float) -> np.ndarray:
        """Poles of the closed loop at one set of gains; of a sampled loop z - 1."""
        return np.roots(self.base + np.asarray(gains) @ self.gains)


def _rows(base: np.ndarray, rows: list[np.ndarray]) -> Loop:
    size = max(p.shape[-1] for p in (base, *rows))
    first, *others = (np.concatenate([np.zeros((*p.shape[:-1], size - p.shape[-1])), p], -1) for p in (base, *rows))
    return Loop(first, np.stack(others, -2))


def _times_s(p: np.ndarray, power: int = 1) -> np.ndarray:
    return np.concatenate([p, np.zeros((*p.shape[:-1], power))], -1)


def pd_loop(plant: Transfer) -> Loop:
    r"""PD control, $u = K_p e + K_d \dot e$ (thesis chapter 4); gains `(kp, kd)` in V/rad and V s/rad."""
    num = plant.restoring
    return _rows(plant.den, [num, _times_s(num)])


def pid_loop(plant: Transfer) -> Loop:
    r"""PID control, $u = K_p e + K_i \int e + K_d \dot e$; gains `(kp, ki, kd)` in V/rad, V/(rad s) and V s/rad."""
    num = plant.restoring
    return _rows(_times_s(plant.den), [_times_s(num), num, _times_s(num, 2)])


def waits(late: float, period: float) -> tuple[int, float]:
    """Whole periods in a delay, and what is left of it, in the same unit."""
    whole = int(late / period + 1e-9)
    return whole, max(late - whole * period, 0.0)


def sampled_loop(plant: Transfer, period: float, late: float = 0.0, smooth: float = 0.0) -> Loop:
    r"""The same PD law at a sample `period` [s], its derivative a backward difference filtered over `smooth` [s], the command held
    and `late` [s]: what the controller computes and what the rig itself delays.

    A polynomial in $z - 1$, which stays well conditioned for a short period, where all z lie close to 1.
    Raises `InputError` for a delay of more than `MOST_LATE` periods, whose poles at z = 0 rounding would spread.
    """
    whole, part = waits(late, period)
    if whole > MOST_LATE:
        raise InputError(
            f"commands act {late:g} s after their reading, more than {MOST_LATE} periods of {period:g} s; sample less often"
        )
    A, B, C = _companion(plant)
    step = A @ _integral(A, period)
    new = _integral(A, period - part) @ B  # of the command that comes in during the step
    old = _integral(A, period) @ B - new  # of the one before it
    den, z = np.poly(step), np.ones(2)
    num = np.polyadd(np.polymul(z, _numerator(step, new, C, den)), _numerator(step, old, C, den))
    for _ in range(whole + 1):
        den = np.polymul(den, z)
    num, slope = np.sign(plant.num[0]) * num, np.array([1.0, period / (smooth + period)])
    return _rows(np.polymul(den, slope), [np.polymul(num, slope), np.append(num, 0.0) / (smooth + period)])


def sampled_pid_loop(plant: Transfer, period: float, late: float = 0.0, smooth: float = 0.0) -> Loop:
    """`sampled_loop` with an integral, a sum over the samples before; gains `(kp, ki, kd)`."""
    pd = sampled_loop(plant, period, late, smooth)
    return _rows(_times_s(pd.base), [_times_s(pd.gains[0]), period * pd.gains[0], _times_s(pd.gains[1])])


def _companion(plant: Transfer) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n = len(plant.den) - 1
    A = np.vstack([-plant.den[1:] / plant.den[0], np.eye(n)[:-1]])
    return A, np.eye(n)[0], np.pad(plant.num / plant.den[0], (n - len(plant.num), 0))


def _integral(A: np.ndarray, time: float) -> np.ndarray:
    """Integral of $e^{A t}$ over a time."""
    n = len(A)
    return time * expm(np.block([[A * time, np.eye(n)], [np.zeros((n, 2 * n))]]))[:n, n:]


def _numerator(A: np.ndarray, B: np.ndarray, C: np.ndarray, den: np.ndarray) -> np.ndarray:
    return np.poly(A - np.outer(B, C)) - den


Enters = tuple[tuple[bool, ...], ...]
"""Of every gain, the coefficients that it is part of."""


def _enters(loop: Loop) -> Enters:
    part = np.any(loop.gains != 0.0, axis=tuple(range(loop.gains.ndim - 2)))
    return tuple(tuple(bool(x) for x in row) for row in part)


def _coefficients(enters: Enters, base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple) -> list:
    """Coefficients, each an array over those gains only that it depends on."""
    parts = [*zip(enters, rows, gains, strict=True)]
    return [base[k] + sum(g * row[k] for part, row, g in parts if part[k]) for k in range(len(base))]


@partial(jax.jit, static_argnums=0)
def _stable(enters: Enters, base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple) -> Bool[Array, "..."]:
    return hurwitz(_coefficients(enters, base, rows, gains))


@partial(jax.jit, static_argnums=0)
def _damped(
    enters: Enters, base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple, damping: Scalar | float
) -> Bool[Array, "..."]:
    return within_sector(_coefficients(enters, base, rows, gains), damping)


def stable(loop: Loop, *gains: Float[np.ndarray, "..."], sigma: float = 0.0, damping: float = 0.0) -> np.ndarray:
    """Where every pole of a continuous loop lies left of `-sigma` [1/s], and has at least a `damping` ratio.

    `gains`: arrays that broadcast with each other, as the axes of a grid do.
    """
    moved = loop.mapped(shift(loop.order, sigma))
    found = np.asarray(_stable(_enters(moved), moved.base, moved.gains, gains))
    if damping > 0.0:
        found = found & np.asarray(_damped(_enters(loop), loop.base, loop.gains, gains, damping))
    return np.broadcast_to(found, np.broadcast_shapes(*(np.shape(g) for g in gains)))


def stable_sampled(loop: Loop, *gains: Float[np.ndarray, "..."], radius: float = 1.0) -> np.ndarray:
    """Where every pole of a sampled loop has $|z|$ below `radius`."""
    moved = loop.mapped(disc(loop.order, radius))
    found = np.asarray(_stable(_enters(moved), moved.base, moved.gains, gains))
    return np.broadcast_to(found, np.broadcast_shapes(*(np.shape(g) for g in gains)))


def boundary(plant: Transfer, omega: Float[np.ndarray, " f"], sigma: float = 0.0) -> Float[np.ndarray, "2 f"]:
    r"""Gains `(kp, kd)` at which a pair of poles crosses $-\sigma \pm j\omega$: the D-partition's curve (Neimark 1948),
    $K_p + K_d s = -\mathrm{den}(s)/\mathrm{num}(s)$ at $s = -\sigma + j\omega$."""
    q = _law_at(plant, -sigma + 1j * np.asarray(omega))
    kd = np.imag(q) / omega
    return np.array([np.real(q) + sigma * kd, kd])


def real_boundary(plant: Transfer, kd: Float[np.ndarray, " d"], sigma: float = 0.0) -> Float[np.ndarray, " d"]:
    r"""`kp` at which a real pole crosses $-\sigma$, for given `kd`: the D-partition's straight line."""
    return np.real(_law_at(plant, np.array([-sigma + 0j]))) + sigma * np.asarray(kd)


def _law_at(plant: Transfer, s: np.ndarray) -> np.ndarray:
    num = np.polyval(plant.restoring, s)
    nowhere = np.full(num.shape, np.nan, complex)  # no gain moves a pole to a zero
    return np.divide(-np.polyval(plant.den, s), num, out=nowhere, where=num != 0.0)


class Region(NamedTuple):
    """`stable` (p, d) of PD gains `kp` [V/rad] and `kd` [V s/rad], and the plant behind it: every pole left of `-sigma` [1/s] and
    with a `damping` ratio of at least this; of a loop that is sampled, with a `period` [s] (0: it is not)."""

    kp: np.ndarray
    kd: np.ndarray
    sigma: float
    stable: np.ndarray
    plant: Transfer
    damping: float = 0.0
    period: float = 0.0

    @property
    def share(self) -> float:
        return float(np.mean(self.stable))


def pd_region(
    rig: Rig, kp: np.ndarray, kd: np.ndarray, sigma: float, angle: float = 0.0, damping: float = 0.0
) -> Region:
    """PD gains for which every pole that a gain moves lies left of `-sigma` (thesis Fig. 4.3) and has at least a `damping` ratio."""
    plant = transfer(linearised(rig, angle))
    found = stable(pd_loop(plant), kp[:, None], kd[None, :], sigma=sigma, damping=damping)
    return Region(kp, kd, sigma, found, plant, damping)


BLOCK, TOGETHER = 5_000, 20
"""Gain pairs and plants that are tested at a time: they stay in the cache, and the count of a pair is written once for all."""


@partial(jax.jit, static_argnums=0)
def _votes(
    enters: Enters, base: Float[Array, "k t n"], rows: Float[Array, "k t 2 n"], pairs: Float[Array, "b 2 g"]
) -> Int[Array, "b g"]:
    def of_block(pair: Float[Array, "2 g"]) -> Int[Array, " g"]:
        def add(found: Int[Array, " g"], plants: tuple) -> tuple[Int[Array, " g"], None]:
            each = zip(*plants, strict=True)
            stable = [hurwitz(_coefficients(enters, base, rows, (pair[0], pair[1]))) for base, rows in each]
            return found + sum(s.astype(found.dtype) for s in stable), None

        return jax.lax.scan(add, jnp.zeros(pair.shape[1], jnp.int32), (base, rows))[0]

    return jax.lax.map(of_block, pairs)


def share_of_plants(
    plants: Transfer, kp: np.ndarray, kd: np.ndarray, sigma: float = 0.0, damping: float = 0.0
) -> Float[np.ndarray, "p d"]:
    """Share of plants (k, …) that each PD gain pair stabilises as in `stable`; 1 in the region of them all."""
    if damping > 0.0:
        each = (stable(pd_loop(p), kp[:, None], kd[None, :], sigma=sigma, damping=damping) for p in plants.each())
        return sum(each, start=np.zeros((len(kp), len(kd)))) / len(plants.num)
    loop = pd_loop(plants)
    return _share(loop.mapped(shift(loop.order, sigma)), kp, kd)


def share_of_sampled(loops: Loop, kp: np.ndarray, kd: np.ndarray, radius: float = 1.0) -> Float[np.ndarray, "p d"]:
    """Share of sampled PD loops (k, …) all of whose poles have $|z|$ below `radius`."""
    return _share(loops.mapped(disc(loops.order, radius)), kp, kd)


def _share(moved: Loop, kp: np.ndarray, kd: np.ndarray) -> Float[np.ndarray, "p d"]:
    pairs = np.stack(np.meshgrid(kp, kd, indexing="ij")).reshape(2, -1)
    blocks = -(-pairs.shape[1] // BLOCK)
    size = -(-pairs.shape[1] // blocks)
    padded = np.pad(pairs, ((0, 0), (0, blocks * size - pairs.shape[1])), mode="edge")
    base, rows = (_together(x) for x in moved)
    votes = _votes(_enters(moved), base, rows, np.moveaxis(padded.reshape(2, blocks, size), 1, 0))
    count = np.asarray(votes).ravel()[: pairs.shape[1]]
    return count.reshape(len(kp), len(kd)) / len(moved.base)


def _together(of_plants: np.ndarray) -> np.ndarray:
    """Plants in groups of `TOGETHER`, the last one filled up with some that nothing stabilises."""
    missing = -len(of_plants) % TOGETHER
    filled = np.concatenate([of_plants, np.full((missing, *of_plants.shape[1:]), np.nan)])
    return filled.reshape(-1, TOGETHER, *of_plants.shape[1:])
