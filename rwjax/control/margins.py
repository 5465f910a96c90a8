"""How far a stable loop is from instability: gain, phase, delay and modulus margin."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from rwjax.control.loop_polynomial import LoopPolynomial
from rwjax.control.transfer import Transfer

REAL = 1e-6
"""Share of a root's size below which its imaginary part is rounding."""
SLOWEST = 1e-5
"""Share of half the sampling rate from which on a sampled loop is looked at."""


class Margins(NamedTuple):
    r"""What a stable loop bears.

    Attributes:
        gain: Factors below and above 1 on the loop's gain that it just bears [1]; 0 and infinity where any is borne.
        phase: Phase lag that it just bears [rad].
        delay: Delay that it just bears [s].
        modulus: Least distance $|1 + L(j\omega)|$ of the open loop from -1 [1].
    """

    gain: tuple[float, float]
    phase: float
    delay: float
    modulus: float


def pd_margins(plant: Transfer, kp: float, kd: float) -> Margins:
    r"""Margins of the continuous PD loop $L(s) = P(s)\,(K_p + K_d s)$ of one plant.

    Args:
        plant: Transfer function of the plant.
        kp: Proportional gain [V/rad].
        kd: Derivative gain [V s/rad].

    Returns:
        Its margins; they say nothing of a loop that is not stable.
    """
    return margins(np.polymul(plant.restoring, [kd, kp]), plant.den)


def margins_over(
    plant: Transfer, kp: np.ndarray, kd: np.ndarray, where: Bool[np.ndarray, "p d"]
) -> dict[str, Float[np.ndarray, "p d"]]:
    """Margins of the continuous PD loop over pairs of gains.

    Args:
        plant: Transfer function of the plant.
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.
        where: Pairs whose loop is stable, `(p, d)`.

    Returns:
        Maps `(p, d)` by name: `gain_below` and `gain_above` [1], `phase_rad` [rad], `delay_s` [s] and `modulus` [1]; no
        number where the loop is not stable.
    """
    names = ("gain_below", "gain_above", "phase_rad", "delay_s", "modulus")
    found = np.full((len(names), *where.shape), np.nan)
    for i, j in np.argwhere(where):
        (below, above), *others = pd_margins(plant, float(kp[i]), float(kd[j]))
        found[:, i, j] = below, above, *others
    return dict(zip(names, found, strict=True))


def moduli_over(
    loop: LoopPolynomial, kp: np.ndarray, kd: np.ndarray, where: Bool[np.ndarray, "p d"]
) -> dict[str, Float[np.ndarray, "p d"]]:
    """Modulus margins of a sampled PD loop over pairs of gains.

    Args:
        loop: The sampled loop of one plant.
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.
        where: Pairs whose loop is stable, `(p, d)`.

    Returns:
        Map `(p, d)` of the name `modulus` [1]; no number where the loop is not stable.
    """
    responses, found = frequency_responses(loop), np.full(where.shape, np.nan)
    for i, j in np.argwhere(where):
        found[i, j] = distance_from_minus_one(responses, float(kp[i]), float(kd[j]))
    return {"modulus": found}


def margins(num: np.ndarray, den: np.ndarray) -> Margins:
    """Margins of a strictly proper open loop, exact at the roots of polynomials in ω.

    Args:
        num: Numerator of the open loop [SI], highest power first, `(m,)`.
        den: Denominator of the open loop [SI], `(n,)`.

    Returns:
        Gain, phase, delay and modulus margin; they say nothing of a loop that is not stable.

    Source:
        Franklin, Powell, Emami-Naeini, Feedback Control of Dynamic Systems; modulus: Åström and Murray, Feedback Systems,
        ch. 10.
    """
    (a, b), (c, d) = _on_axis(num), _on_axis(den)  # num = a + jb, den = c + jd at s = jω
    size, whole = _square(a, b), _square(c, d)
    cross = np.polysub(np.polymul(b, c), np.polymul(a, d))  # of num times conj(den): imaginary part
    along = np.polyadd(np.polymul(a, c), np.polymul(b, d))
    still = [0.0] if den[-1] != 0.0 else []  # an integrator has no finite gain there
    at = [w for w in (*_positive(cross), *still) if np.polyval(along, w) < 0.0]
    factors = [float(-np.polyval(whole, w) / np.polyval(along, w)) for w in at]
    crossings = _positive(np.polysub(size, whole))
    loop = [np.polyval(num, 1j * w) / np.polyval(den, 1j * w) for w in crossings]
    lag = [float(np.mod(np.angle(x) + np.pi, 2.0 * np.pi)) for x in loop]
    both = _square(np.polyadd(a, c), np.polyadd(b, d))
    flat = np.polysub(np.polymul(np.polyder(both), whole), np.polymul(both, np.polyder(whole)))
    away = [abs(1.0 + np.polyval(num, 1j * w) / np.polyval(den, 1j * w)) for w in (*_positive(flat), *still)]
    return Margins(
        gain=(max([g for g in factors if g < 1.0], default=0.0), min([g for g in factors if g > 1.0], default=np.inf)),
        phase=min([min(x, 2.0 * np.pi - x) for x in lag], default=np.inf),
        delay=min([x / w for x, w in zip(lag, crossings, strict=True)], default=np.inf),
        modulus=float(min([1.0, *away])),  # 1 at high frequencies
    )


def frequency_responses(loop: LoopPolynomial, frequencies: int = 4000) -> np.ndarray:
    """Frequency response of a sampled open loop by each gain, along the unit circle.

    Args:
        loop: Sampled loop of one plant, or of many.
        frequencies: Number of frequencies f [1], up to half the sampling rate.

    Returns:
        Response per unit of each gain [SI], complex, `(..., g, f)`.
    """
    z = np.exp(1j * np.pi * np.geomspace(SLOWEST, 1.0, frequencies)) - 1.0
    powers = z ** np.arange(loop.order + 1)[::-1, None]
    return (loop.gains @ powers) / (loop.base @ powers)[..., None, :]


def sampled_modulus(loop: LoopPolynomial, *gains: float) -> float:
    """Modulus margin of a sampled loop [1], to the grid of frequencies.

    Args:
        loop: The sampled loop of one plant.
        *gains: One value for each gain, in its unit.

    Returns:
        Least distance of the open loop from -1 [1].
    """
    return distance_from_minus_one(frequency_responses(loop), *gains)


def distance_from_minus_one(responses: np.ndarray, *gains: float) -> float:
    """Least distance from -1 of an open loop [1].

    Args:
        responses: Its frequency response by each gain [SI] (`frequency_responses`), `(g, f)`.
        *gains: One value for each gain, in its unit.

    Returns:
        The distance [1].
    """
    return float(np.min(np.abs(1.0 + np.asarray(gains) @ responses)))


def _on_axis(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Real and imaginary part of p(jω) as polynomials in ω."""
    turn = np.resize([1.0, 1.0, -1.0, -1.0], len(p))[::-1]  # of 1, jω, (jω)^2, ...
    even = np.arange(len(p))[::-1] % 2 == 0
    return np.where(even, turn * p, 0.0), np.where(even, 0.0, turn * p)


def _square(re: np.ndarray, im: np.ndarray) -> np.ndarray:
    """Squared size of a polynomial from its real and imaginary part."""
    return np.polyadd(np.polymul(re, re), np.polymul(im, im))


def _positive(p: np.ndarray) -> list[float]:
    """Positive real roots."""
    roots = np.roots(np.trim_zeros(p, "f")) if np.any(p) else np.zeros(0)
    return [float(r.real) for r in roots if abs(np.imag(r)) <= REAL * abs(r) and np.real(r) > 0.0]
