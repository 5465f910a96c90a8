"""Gains that stabilise: which of many gain pairs put every pole of the closed loop where it should be.

The characteristic polynomial is affine in the gains, so one array expression tests all of them (`rwjax.control.polynomials`).
"""

from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Bool, Float
from scipy.linalg import expm

from rwjax.control.linear import Transfer, linearised, transfer
from rwjax.control.polynomials import disc, hurwitz, shift, within_sector
from rwjax.rig import Rig


class Loop(NamedTuple):
    r"""Characteristic polynomial of a closed loop, $p_0 + \sum_g K_g\,p_g$, highest power first: `base` (n + 1,) and one row of
    `gains` (g, n + 1) for every gain. Positive gains restore, whatever the plant's sign."""

    base: np.ndarray
    gains: np.ndarray

    def mapped(self, M: np.ndarray) -> "Loop":
        """The loop after a linear map of its coefficients."""
        return Loop(M @ self.base, self.gains @ M.T)

    @property
    def order(self) -> int:
        return len(self.base) - 1

    def poles(self, *gains: float) -> np.ndarray:
        """Poles of the closed loop at one set of gains."""
        return np.roots(self.base + np.asarray(gains) @ self.gains)


def _rows(base: np.ndarray, rows: list[np.ndarray]) -> Loop:
    size = max(len(p) for p in (base, *rows))
    first, *others = (np.pad(p, (size - len(p), 0)) for p in (base, *rows))
    return Loop(first, np.array(others))


def pd_loop(plant: Transfer) -> Loop:
    r"""PD control, $u = K_p e + K_d \dot e$ (thesis chapter 4); gains `(kp, kd)` in V/rad and V s/rad."""
    num = plant.sign * plant.num
    return _rows(plant.den, [num, np.append(num, 0.0)])


def pid_loop(plant: Transfer) -> Loop:
    r"""PID control, $u = K_p e + K_i \int e + K_d \dot e$; gains `(kp, ki, kd)` in V/rad, V/(rad s) and V s/rad."""
    num = plant.sign * plant.num
    return _rows(np.append(plant.den, 0.0), [np.append(num, 0.0), num, np.append(num, [0.0, 0.0])])


def sampled_loop(plant: Transfer, period: float, late: float = 0.0) -> Loop:
    r"""The same PD law at a sample `period` [s], its derivative a backward difference, the command held and `late` [s]: what
    the controller computes and what the rig itself delays.

    A polynomial in $\delta = (z - 1)/h$, which stays well conditioned for a short period (Middleton and Goodwin 1986).
    """
    whole = int(np.floor(late / period + 1e-9))
    part = max(late - whole * period, 0.0)
    A, B, C = _companion(plant)
    step = A @ _mean(A, period)
    new = (1.0 - part / period) * _mean(A, period - part) @ B  # of the command that comes in during the step
    old = _mean(A, period) @ B - new  # of the one before it
    den, advance = np.poly(step), np.array([period, 1.0])
    num = np.polyadd(np.polymul(advance, _numerator(step, new, C, den)), _numerator(step, old, C, den))
    for _ in range(whole + 1):
        den = np.polymul(den, advance)
    num = plant.sign * num
    return _rows(np.polymul(den, advance), [np.polymul(num, advance), np.append(num, 0.0)])


def _companion(plant: Transfer) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n = len(plant.den) - 1
    A = np.vstack([-plant.den[1:] / plant.den[0], np.eye(n)[:-1]])
    return A, np.eye(n)[0], np.pad(plant.num / plant.den[0], (n - len(plant.num), 0))


def _mean(A: np.ndarray, time: float) -> np.ndarray:
    """Mean of $e^{A t}$ over a time."""
    n = len(A)
    return expm(np.block([[A * time, np.eye(n)], [np.zeros((n, 2 * n))]]))[:n, n:]


def _numerator(A: np.ndarray, B: np.ndarray, C: np.ndarray, den: np.ndarray) -> np.ndarray:
    return np.poly(A - np.outer(B, C)) - den


@jax.jit
def _coefficients(base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple) -> list:
    return [base[k] + sum(g * row[k] for g, row in zip(gains, rows, strict=True)) for k in range(len(base))]


@jax.jit
def _stable(base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple) -> Bool[Array, "..."]:
    return hurwitz(_coefficients(base, rows, gains))


@jax.jit
def _damped(base: Float[Array, " n"], rows: Float[Array, "g n"], gains: tuple, damping: float) -> Bool[Array, "..."]:
    return within_sector(_coefficients(base, rows, gains), damping)


def stable(loop: Loop, *gains: Float[np.ndarray, "..."], sigma: float = 0.0, damping: float = 0.0) -> np.ndarray:
    """Where every pole of a continuous loop lies left of `-sigma` [1/s], and has at least a `damping` ratio.

    `gains`: arrays that broadcast with each other, as the axes of a grid do.
    """
    moved = loop.mapped(shift(loop.order, sigma))
    found = _stable(moved.base, moved.gains, gains)
    if damping > 0.0:
        found = found & _damped(loop.base, loop.gains, gains, damping)
    return np.asarray(found)


def stable_sampled(loop: Loop, *gains: Float[np.ndarray, "..."], period: float, radius: float = 1.0) -> np.ndarray:
    """Where every pole of a loop of that sample `period` has $|z|$ below `radius`."""
    moved = loop.mapped(disc(loop.order, radius, period))
    return np.asarray(_stable(moved.base, moved.gains, gains))


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
    return -np.polyval(plant.den, s) / np.polyval(plant.sign * plant.num, s)


class Region(NamedTuple):
    """`stable` (p, d) of PD gains `kp` [V/rad] and `kd` [V s/rad], and the plant behind it."""

    kp: np.ndarray
    kd: np.ndarray
    sigma: float
    stable: np.ndarray
    plant: Transfer

    @property
    def share(self) -> float:
        return float(np.mean(self.stable))


def pd_region(rig: Rig, kp: np.ndarray, kd: np.ndarray, sigma: float, angle: float = 0.0) -> Region:
    """PD gains for which every pole that a gain moves lies left of `-sigma` (thesis Fig. 4.3)."""
    plant = transfer(linearised(rig, angle))
    found = stable(pd_loop(plant), kp[:, None], kd[None, :], sigma=sigma)
    return Region(kp, kd, sigma, found, plant)
