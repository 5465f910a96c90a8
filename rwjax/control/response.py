"""What a step response shows: overshoot, settling, the error that stays, saturation, limit cycles."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from rwjax.control.closed_loop import Run
from rwjax.types import Scalar

BAND = 0.02
"""Share of a step within which the angle counts as settled."""
LATE = 0.25
"""Share of a response, its end, over which what stays is judged."""


class Response(NamedTuple):
    """`overshoot` beyond the step, as a share of it (0 where there is none); `settling` [s] until the angle stays within
    `BAND`, infinite where it never does; over the last `LATE` of the time: mean `error` [rad] and half the range of the
    angle, the `cycle` [rad]; `saturated`: share of the time at the command's limit; `fastest` rate of the wheel [rad/s]."""

    overshoot: Float[Array, "..."]
    settling: Float[Array, "..."]
    error: Float[Array, "..."]
    cycle: Float[Array, "..."]
    saturated: Float[Array, "..."]
    fastest: Float[Array, "..."]


def step_response(run: Run, target: Scalar | float, period: float, limit: Scalar | float = jnp.inf) -> Response:
    """Response of runs `(…, s)` to a step of the reference to `target` [rad] at their first sample."""
    angle = jnp.asarray(run.angle)
    step = target - angle[..., :1]
    size = jnp.abs(step)
    way = (angle - angle[..., :1]) * jnp.sign(step)
    n = angle.shape[-1]
    outside = ~(jnp.abs(target - angle) <= BAND * size)  # as is what diverged and is no number
    last = n - jnp.argmax(outside[..., ::-1], axis=-1)  # samples until the last one outside, it included
    settled = jnp.where(last < n, period * last.astype(float), jnp.inf)
    end = angle[..., n - max(int(LATE * n), 1) :]
    return Response(
        overshoot=jnp.maximum(way.max(-1) / size[..., 0] - 1.0, 0.0),
        settling=jnp.where(outside.any(-1), settled, 0.0),
        error=jnp.mean(target - end, axis=-1),
        cycle=0.5 * jnp.ptp(end, axis=-1),
        saturated=jnp.mean((jnp.abs(jnp.asarray(run.command)) >= limit * (1.0 - 1e-12)).astype(float), axis=-1),
        fastest=jnp.max(jnp.abs(jnp.asarray(run.wheel)), axis=-1),
    )
