"""The PD gains with the largest worst-case margin over many plants, as a fit leaves them possible."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.closed_loop import refuse_lags
from rwjax.control.controller import DEFAULT_TIMING, LoopTiming
from rwjax.control.loop_polynomial import LoopPolynomial
from rwjax.control.margins import frequency_responses, sampled_modulus
from rwjax.control.sampled_loop import SampledLaw, sampled_loops, stacked_loops
from rwjax.control.stability import share_of_sampled
from rwjax.errors import InputError
from rwjax.rig.model import Rig

FREQUENCIES = 300
"""Frequencies at which the worst-case margin of a map is taken; that of the chosen gains is taken at many more."""
ROUNDS = 4
"""Times that the map is drawn closer round its best gains."""
GRID = 31
"""Gains along each axis of the map."""
SMALLEST = 1e-5
"""Smallest gain of the map, over the largest of its range: light rigs want small gains."""
BEYOND = 1e3
"""Largest gain that is looked at to say whether any would do, over the largest of its range."""


class RobustGains(NamedTuple):
    """PD gains that meet the criterion with every plant.

    Attributes:
        kp: Proportional gain [V/rad].
        kd: Derivative gain [V s/rad].
        modulus: Worst modulus margin of all plants [1].
    """

    kp: float
    kd: float
    modulus: float


def robust_gains(
    rig: Rig,
    thetas: Float[np.ndarray, "k p"],
    kp: np.ndarray,
    kd: np.ndarray,
    sigma: float,
    timing: LoopTiming = DEFAULT_TIMING,
    filter_time: float = 0.0,
) -> RobustGains:
    r"""The gains within two ranges with the largest worst-case modulus margin over many plants.

    Among those with which every pole of every plant's loop has $|z| < e^{-\sigma h}$: the loop as it runs, sampled, held,
    delayed, its derivative filtered. (The continuous loop of a plant that falls with s² never comes near -1 with gains
    however high.) `kp` is never 0, since nothing would bring the axis to its angle.

    Args:
        rig: The rig whose structure the plants have.
        thetas: Parameter vectors [SI], one plant for each row.
        kp: Proportional gains [V/rad], 0 or more; the least and the largest are the ends of the range.
        kd: Derivative gains [V s/rad], 0 or more, likewise.
        sigma: Rate at which every motion of the loop dies away at least [1/s].
        timing: When the controller reads and acts, without the plants' own delays.
        filter_time: Time constant of the derivative's filter [s].

    Returns:
        The gains and their worst modulus margin.

    Raises:
        InputError: As `sampled_loops` and `refuse_lags` do, and where no gains meet the criterion.
    """
    refuse_lags(rig)
    each = sampled_loops(rig, SampledLaw(timing, filter_time), thetas)
    loops = stacked_loops(each)
    radius = float(np.exp(-sigma * timing.period))
    ends = [(float(np.min(gains)), float(np.max(gains))) for gains in (kp, kd)]
    responses = frequency_responses(loops, FREQUENCIES)
    parts = jnp.asarray(np.real(responses)), jnp.asarray(np.imag(responses))
    p, d = (np.union1d(_geometric(*end, end[1]), np.linspace(*end, GRID)) for end in ends)
    best = (0.0, 0.0)
    for _ in range(ROUNDS):
        holds = (share_of_sampled(loops, p, d, radius) == 1.0) & (p > 0.0)[:, None]
        if not holds.any():
            raise InputError(_refusal(loops, ends, sigma, radius))
        margin = np.where(holds, np.asarray(_least_modulus(*parts, jnp.asarray(p), jnp.asarray(d))), -1.0)
        at = np.unravel_index(np.argmax(margin), margin.shape)
        best = float(p[at[0]]), float(d[at[1]])
        p, d = (
            _geometric(float(x[max(k - 2, 0)]), float(x[min(k + 2, len(x) - 1)]), high)
            for x, k, (_, high) in zip((p, d), at, ends, strict=True)
        )
    worst = min(sampled_modulus(loop, *best) for loop in each)
    return RobustGains(*best, worst)


@jax.jit
def _least_modulus(
    re: Float[Array, "k 2 f"], im: Float[Array, "k 2 f"], kp: Float[Array, " p"], kd: Float[Array, " d"]
) -> Float[Array, "p d"]:
    """Least of |1 + L| over plants and frequencies, given the parts of L by each gain."""

    def of(kp: Array, kd: Array) -> Array:
        real, imaginary = (kp * x[:, 0] + kd * x[:, 1] for x in (re, im))
        return jnp.sqrt(jnp.min((1.0 + real) ** 2 + imaginary**2))

    return jax.lax.map(lambda p: jax.lax.map(lambda d: of(p, d), kd), kp)


def _geometric(low: float, high: float, most: float) -> np.ndarray:
    """Gains from `low` to `high` in equal ratios, of a range up to `most`; 0 is among them where `low` is 0."""
    found = np.geomspace(max(low, SMALLEST * most), high, GRID) if high > 0.0 else np.zeros(1)
    return np.append(0.0, found) if low == 0.0 else found


def _refusal(loops: LoopPolynomial, ends: list[tuple[float, float]], sigma: float, radius: float) -> str:
    """What to say where no gains within the ranges meet the criterion: whether others do."""
    kp, kd = (_geometric(0.0, BEYOND * high, high) for _, high in ends)
    if np.any(share_of_sampled(loops, kp[1:], kd, radius) == 1.0):
        return f"no gains within --kp and --kd put every pole of every plant left of -{sigma:g} 1/s; others do, widen these"
    return (
        f"no gains put every pole of every plant left of -{sigma:g} 1/s; ask for less, sample faster, or fit more logs"
    )
