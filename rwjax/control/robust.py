"""Gains for a plant that is known only so well: plants drawn from a fit's covariance, and the largest worst-case margin."""

import json
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.closed_loop import LoopTiming, without_lags
from rwjax.control.margins import on_circle, sampled_modulus
from rwjax.control.region import Loop, share_of_sampled
from rwjax.control.sampled_loop import running_loops, side_by_side
from rwjax.errors import InputError
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.text_files import read_text

FREQUENCIES = 300
"""Along which the worst-case margin of a map is taken; that of the chosen gains along many more."""
ROUNDS, GRID = 4, 31
"""Times that the map is drawn closer round its best gains, and its gains along each axis."""
SMALLEST, BEYOND = 1e-5, 1e3
"""Shares of the largest gains: the smallest that counts as one, and the largest that is looked at to say whether any would do."""
TRIES = 100


class Spread(NamedTuple):
    """What a fit says of some numbers: their `names`, estimates `mean` (n,) and `covariance` (n, n). `per_run`: those of which every
    run has a value of its own; here stands the mean of the runs, and the scatter between them counts, since a plant is a run."""

    names: tuple[str, ...]
    mean: Float[np.ndarray, " n"]
    covariance: Float[np.ndarray, "n n"]
    per_run: tuple[str, ...] = ()


def read_spread(path: Path, rig: Rig) -> Spread:
    """What `rwjax fit --json` wrote for this rig. Raises `InputError` for anything else, and for numbers of which the logs
    say nothing."""
    try:
        found = json.loads(read_text(path, InputError))
        if (fitted := found.get("rig", rig.name)) != rig.name:
            raise InputError(f"{path}: is a fit of rig `{fitted}`, not of `{rig.name}`; give the rig file of that fit")
        if "numbers" in found and "covariance_of" not in found:
            raise InputError(f"{path}: no `covariance`, as of the two-stage method; fit end to end")
        every = {name: name.split(" in ")[0] for name in found["covariance_of"]}  # `NAME in LOG`: a run's own
        names = tuple(dict.fromkeys(every.values()))
        silent = [name for k, name in enumerate(every) if found["covariance"][k][k] is None]
        if silent:
            raise InputError(
                f"{path}: `covariance`: the logs say nothing of {', '.join(silent)}; take it out of fit.free"
            )
        values = np.array([found["numbers"][name]["value"] for name in every], float)
        covariance = np.array(found["covariance"], float).reshape(len(every), len(every))
    except (json.JSONDecodeError, AttributeError, KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: is not what `rwjax fit RIG LOG… --json` prints; save that to a file") from None
    if not names:
        raise InputError(f"{path}: `covariance_of` is empty, the fit estimates no number; leave --fit out")
    of_effects = (name for name in rig.free if name.rpartition(".")[0] in rig.effects)  # as a diagnosis adds them
    if (other := next((name for name in of_effects if name not in names), None)) is not None:
        raise InputError(f"{path}: a fit without `{other}`, which the rig file frees; run `rwjax fit` on that rig file")
    of = np.array([[shared == name for shared in every.values()] for name in names], float)
    of /= of.sum(axis=1, keepdims=True)  # the mean of the runs
    per_run = tuple(dict.fromkeys(shared for name, shared in every.items() if name != shared))
    runs = [values[row > 0.0] for row in of]
    scatter = np.diag([np.var(own, ddof=1) if len(own) > 1 else 0.0 for own in runs])
    return Spread(names, of @ values, of @ covariance @ of.T + scatter, per_run)


def fitted(rig: Rig, spread: Spread) -> Rig:
    """The rig with the fit's estimates. Raises `InputError` for numbers that the rig lacks."""
    if strange := [name for name in spread.names if name not in rig.values]:
        raise InputError(f"the fit estimates `{strange[0]}`, which this rig lacks; give the fitted rig file")
    return rig.with_values(dict(zip(spread.names, map(float, spread.mean), strict=True)))


def draw(rig: Rig, spread: Spread, count: int, seed: int = 0) -> Float[np.ndarray, "k p"]:
    """Parameter vectors of plants drawn from a fit's normal distribution, those beyond the physical bounds drawn again.

    Raises `InputError` as `fitted` does and where hardly any draw is possible.
    """
    structure = structure_of(fitted(rig, spread))
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
    re: Float[Array, "k 2 f"], im: Float[Array, "k 2 f"], kp: Float[Array, " p"], kd: Float[Array, " d"]
) -> Float[Array, "p d"]:
    """Least of |1 + L| over plants and frequencies, given the parts of L by each gain."""

    def of(kp: Array, kd: Array) -> Array:
        real, imaginary = (kp * x[:, 0] + kd * x[:, 1] for x in (re, im))
        return jnp.sqrt(jnp.min((1.0 + real) ** 2 + imaginary**2))

    return jax.lax.map(lambda p: jax.lax.map(lambda d: of(p, d), kd), kp)


class Robust(NamedTuple):
    """PD gains `kp` [V/rad], `kd` [V s/rad] with which no drawn plant is as slow as `-sigma`, and the worst `modulus` margin of
    them all."""

    kp: float
    kd: float
    modulus: float


def robust_gains(
    rig: Rig,
    thetas: Float[np.ndarray, "k p"],
    kp: np.ndarray,
    kd: np.ndarray,
    sigma: float,
    clockwork: LoopTiming = LoopTiming(),  # noqa: B008 (a tuple, which nothing changes)
    smooth: float = 0.0,
) -> Robust:
    r"""The gains within the axes' range with the largest worst-case modulus margin over plants, among those with which every pole
    of every plant's loop has $|z| < e^{-\sigma h}$: the loop as it runs, sampled, held, late, its derivative filtered over
    `smooth` [s]. (The continuous loop of a plant that falls with s² never comes near -1 with gains however high.) K_p is never 0,
    since nothing would bring the axis to its angle; both ranges begin at 0 or above.

    Raises `InputError` as `running_loops` and `without_lags` do, and where no gains do.
    """
    without_lags(rig)
    each = running_loops(rig, clockwork, smooth, thetas)
    loops = side_by_side(each)
    radius = float(np.exp(-sigma * clockwork.period))
    ends = [(float(np.min(gains)), float(np.max(gains))) for gains in (kp, kd)]
    seen = on_circle(loops, FREQUENCIES)
    parts = jnp.asarray(np.real(seen)), jnp.asarray(np.imag(seen))
    p, d = (np.union1d(_spread(*end, end[1]), np.linspace(*end, GRID)) for end in ends)
    best = (0.0, 0.0)
    for _ in range(ROUNDS):
        holds = (share_of_sampled(loops, p, d, radius) == 1.0) & (p > 0.0)[:, None]
        if not holds.any():
            raise InputError(_refusal(loops, ends, sigma, radius))
        margin = np.where(holds, np.asarray(_least_modulus(*parts, jnp.asarray(p), jnp.asarray(d))), -1.0)
        at = np.unravel_index(np.argmax(margin), margin.shape)
        best = float(p[at[0]]), float(d[at[1]])
        p, d = (
            _spread(float(x[max(k - 2, 0)]), float(x[min(k + 2, len(x) - 1)]), high)
            for x, k, (_, high) in zip((p, d), at, ends, strict=True)
        )
    worst = min(sampled_modulus(loop, *best) for loop in each)
    return Robust(*best, worst)


def _spread(low: float, high: float, most: float) -> np.ndarray:
    """Gains from `low` to `high`, geometric, 0 among them where `low` is: light rigs want small gains of a range up to `most`."""
    found = np.geomspace(max(low, SMALLEST * most), high, GRID) if high > 0.0 else np.zeros(1)
    return np.append(0.0, found) if low == 0.0 else found


def _refusal(loops: Loop, ends: list[tuple[float, float]], sigma: float, radius: float) -> str:
    """What to say where no gains do within the ranges: whether others do."""
    kp, kd = (_spread(0.0, BEYOND * high, high) for _, high in ends)
    if np.any(share_of_sampled(loops, kp[1:], kd, radius) == 1.0):
        return f"no gains within --kp and --kd put every pole of every plant left of -{sigma:g} 1/s; others do, widen these"
    return (
        f"no gains put every pole of every plant left of -{sigma:g} 1/s; ask for less, sample faster, or fit more logs"
    )
