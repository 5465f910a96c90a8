"""Gains for a plant that is known only so well: plants drawn from a fit's covariance, and the largest worst-case margin."""

import json
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.build import bounds_of, structure_of, theta_of
from rwjax.control.linear import Transfer, linearised, transfer
from rwjax.control.margins import Margins, pd_margins
from rwjax.control.region import share_of_plants
from rwjax.errors import InputError, read_text
from rwjax.rig import Rig

FREQUENCIES = 300
"""Along which the worst-case margin of a map is taken; the margins of the chosen gains are exact."""
ROUNDS, GRID = 4, 31
"""Times that the map is drawn closer round its best gains, and its gains along each axis."""
TRIES = 100


class Spread(NamedTuple):
    """What a fit says of some numbers: their `names`, estimates `mean` (n,) and `covariance` (n, n)."""

    names: tuple[str, ...]
    mean: Float[np.ndarray, " n"]
    covariance: Float[np.ndarray, "n n"]


def read_spread(path: Path) -> Spread:
    """What `rwjax fit --json` wrote. Raises `InputError` for anything else, and for numbers of which the logs say nothing."""
    try:
        found = json.loads(read_text(path, InputError))
        names = tuple(found["covariance_of"])
        if any(v is None for row in found["covariance"] for v in row):
            raise InputError(
                f"{path}: `covariance`: the logs say nothing of some of {', '.join(names)}; fix these numbers"
            )
        mean = np.array([found["numbers"][name]["value"] for name in names], float)
        covariance = np.array(found["covariance"], float).reshape(len(names), len(names))
    except (json.JSONDecodeError, KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: is not what `rwjax fit RIG LOG… --json` prints; save that to a file") from None
    return Spread(names, mean, covariance)


def draw(rig: Rig, spread: Spread, count: int, seed: int = 0) -> Float[np.ndarray, "k p"]:
    """Parameter vectors of plants drawn from a fit's normal distribution, those beyond the physical bounds drawn again.

    Raises `InputError` for numbers that the rig lacks and where hardly any draw is possible.
    """
    structure = structure_of(rig)
    if strange := [name for name in spread.names if name not in structure.names]:
        raise InputError(f"the fit estimates `{strange[0]}`, which this rig lacks; give the fitted rig file")
    at = [structure.names.index(name) for name in spread.names]
    low, high = bounds_of(rig, structure)[at].T
    rng, found = np.random.default_rng(seed), np.empty((0, len(at)))
    for _ in range(TRIES):
        fresh = rng.multivariate_normal(spread.mean, spread.covariance, size=count, method="eigh")
        found = np.concatenate([found, fresh[np.all((fresh > low) & (fresh < high), axis=1)]])[:count]
        if len(found) == count:
            thetas = np.tile(theta_of(rig, structure), (count, 1))
            thetas[:, at] = found
            return thetas
    raise InputError(
        "the fit's covariance reaches far beyond what is possible; fit more logs, or fix some of its numbers"
    )


@jax.jit
def _least_modulus(
    re: Float[Array, "k f"],
    im: Float[Array, "k f"],
    omega: Float[Array, " f"],
    kp: Float[Array, " p"],
    kd: Float[Array, " d"],
) -> Float[Array, "p d"]:
    r"""Least of $|1 + P(j\omega)(K_p + K_d\,j\omega)|$ over plants, given by the parts of P, and frequencies."""

    def of(kp: Array, kd: Array) -> Array:
        swift = kd * omega[None, :]
        return jnp.sqrt(jnp.min((1.0 + re * kp - im * swift) ** 2 + (im * kp + re * swift) ** 2))

    return jax.lax.map(lambda p: jax.lax.map(lambda d: of(p, d), kd), kp)


class Robust(NamedTuple):
    """PD gains `kp` [V/rad], `kd` [V s/rad] for which every drawn plant has all poles left of `-sigma`, the worst `modulus`
    margin of them all, and the worst of each margin, `worst`."""

    kp: float
    kd: float
    modulus: float
    worst: Margins


def robust_gains(rig: Rig, thetas: Float[np.ndarray, "k p"], kp: np.ndarray, kd: np.ndarray, sigma: float) -> Robust:
    """The gains within the axes' range with the largest worst-case modulus margin over plants, among those that put every pole
    of every plant left of `-sigma`. Raises `InputError` where no gains do."""
    plants = transfer(linearised(rig, thetas=thetas))
    lows, highs = np.array([kp.min(), kd.min()]), np.array([kp.max(), kd.max()])
    omega = _frequencies(plants)
    response = _along(plants.restoring, omega) / _along(plants.den, omega)
    seen = jnp.asarray(response.real), jnp.asarray(response.imag), jnp.asarray(omega)
    low, high, best = lows, highs, np.zeros(2)
    for _ in range(ROUNDS):
        p, d = (np.linspace(a, b, GRID) for a, b in zip(low, high, strict=True))
        holds = share_of_plants(plants, p, d, sigma) == 1.0
        if not holds.any():
            raise InputError(
                f"no gains put every pole of every plant left of -{sigma:g} 1/s; ask for less, or fit more logs"
            )
        margin = np.where(holds, np.asarray(_least_modulus(*seen, jnp.asarray(p), jnp.asarray(d))), -1.0)
        i, j = np.unravel_index(np.argmax(margin), margin.shape)
        best, reach = np.array([p[i], d[j]]), 2.0 * (high - low) / (GRID - 1)
        low, high = np.maximum(best - reach, lows), np.minimum(best + reach, highs)
    each = [pd_margins(plant, *best) for plant in _one_by_one(plants)]
    worst = Margins(
        (max(m.gain[0] for m in each), min(m.gain[1] for m in each)),
        *(min(getattr(m, k) for m in each) for k in Margins._fields[1:]),
    )
    return Robust(float(best[0]), float(best[1]), worst.modulus, worst)


def _frequencies(plants: Transfer) -> Float[np.ndarray, " f"]:
    """From well below to well above all poles of the plants [rad/s]."""
    sizes = np.abs(np.concatenate([np.roots(p) for p in plants.den]))
    sizes = sizes[sizes > 0.0] if np.any(sizes > 0.0) else np.ones(1)
    return np.geomspace(1e-2 * sizes.min(), 1e3 * sizes.max(), FREQUENCIES)


def _along(polynomials: np.ndarray, omega: np.ndarray) -> np.ndarray:
    powers = (1j * omega) ** np.arange(polynomials.shape[-1])[::-1, None]
    return polynomials @ powers


def _one_by_one(plants: Transfer) -> list[Transfer]:
    return [Transfer(num, den, plants.hidden) for num, den in zip(plants.num, plants.den, strict=True)]
