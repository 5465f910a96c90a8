"""What a step response shows: overshoot, settling, the error that stays, saturation, limit cycles."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from rwjax.control.closed_loop import Run

BAND = 0.02
"""Share of a step within which the angle counts as settled."""
LATE = 0.25
"""Share of a response, its end, over which what stays is judged."""


class Response(NamedTuple):
    """`overshoot` beyond the step, as a share of it (0 where there is none); `settling` [s] until the angle stays within
    `BAND`, infinite where it never does; over the last `LATE` of the time: mean `error` [rad] and half the range of the
    angle, the `cycle` [rad]; `saturated`: share of the time at the command's limit."""

    overshoot: np.ndarray
    settling: np.ndarray
    error: np.ndarray
    cycle: np.ndarray
    saturated: np.ndarray


def step_response(run: Run, target: float, period: float, limit: float = np.inf) -> Response:
    """Response of runs `(…, s)` to a step of the reference to `target` [rad] at their first sample."""
    angle, command = np.asarray(run.angle), np.asarray(run.command)
    step = target - angle[..., :1]
    size = np.abs(step)
    way = (angle - angle[..., :1]) * np.sign(step)
    off = np.abs(target - angle)
    n = angle.shape[-1]
    outside = off > BAND * size
    last = n - np.argmax(outside[..., ::-1], axis=-1)  # samples until the last one outside, it included
    settled = np.where(outside.any(-1), np.where(last < n, period * last, np.inf), 0.0)
    end: Float[np.ndarray, ...] = angle[..., n - max(int(LATE * n), 1) :]
    return Response(
        overshoot=np.maximum(way.max(-1) / size[..., 0] - 1.0, 0.0),
        settling=settled,
        error=np.mean(target - end, axis=-1),
        cycle=0.5 * np.ptp(end, axis=-1),
        saturated=np.mean(np.abs(command) >= limit * (1.0 - 1e-12), axis=-1),
    )
