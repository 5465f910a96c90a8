"""What a step response shows: overshoot, settling, the error that stays, saturation, limit cycles."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.closed_loop import ClosedLoopRun
from rwjax.errors import InputError
from rwjax.types import Scalar

BAND = 0.02
"""Share of a step within which the angle counts as settled."""
LATE = 0.25
"""Share of a response, its end, over which what stays is judged."""


@dataclass(frozen=True)
class StepReference:
    """A step of the reference at the first sample, from angle 0.

    Attributes:
        angle: Angle to which it steps [rad].
        seconds: Length of the response [s].
    """

    angle: float = math.radians(10.0)
    seconds: float = 10.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.angle) and self.angle != 0.0):
            raise InputError(f"step of {self.angle:g} rad: has to be a number other than 0")

    def samples(self, period: float) -> Float[np.ndarray, " s"]:
        """The reference at a controller's samples.

        Args:
            period: Sampling period [s].

        Returns:
            Angles [rad], `(s,)`.

        Raises:
            InputError: Where less than 10 samples or more than a million belong to the response.
        """
        count = round(self.seconds / period) if self.seconds > 0.0 else 0
        if not 10 <= count <= 1_000_000:
            raise InputError(f"seconds {self.seconds:g}: has to hold 10 to 1000000 samples of {period:g} s")
        return np.full(count, self.angle)


DEFAULT_STEP = StepReference()
"""10 degrees, looked at for 10 s."""


class Response(NamedTuple):
    """Figures of step responses `(...)`.

    Attributes:
        overshoot: Way beyond the step, as a share of it [1]; 0 where there is none.
        settling: Time until the angle stays within `BAND` of the step [s]; infinite where it never does.
        error: Mean error over the last `LATE` of the time [rad].
        cycle: Half the range of the angle over that time, the size of a limit cycle [rad].
        saturated: Share of the time at the command's limit [1].
        fastest: Largest rate of the wheel, either way [rad/s].
    """

    overshoot: Float[Array, "..."]
    settling: Float[Array, "..."]
    error: Float[Array, "..."]
    cycle: Float[Array, "..."]
    saturated: Float[Array, "..."]
    fastest: Float[Array, "..."]


def step_response(
    run: ClosedLoopRun, target: Scalar | float, period: float, voltage_limit: Scalar | float = jnp.inf
) -> Response:
    """Figures of the response to a step of the reference at the first sample.

    Args:
        run: Runs of the loop, `(..., s)`.
        target: Angle to which the reference steps [rad].
        period: Sampling period [s].
        voltage_limit: Largest command [V].

    Returns:
        The figures, `(...)`. A run that diverged never settles.
    """
    angle = jnp.asarray(run.angle)
    step = target - angle[..., :1]
    size = jnp.abs(step)
    way = (angle - angle[..., :1]) * jnp.sign(step)
    n = angle.shape[-1]
    outside = ~(jnp.abs(target - angle) <= BAND * size)  # as is what diverged and is no number
    last = jnp.max(
        jnp.where(outside, jnp.arange(1, n + 1), 0), axis=-1
    )  # samples until the last one outside, it included
    end = angle[..., n - max(int(LATE * n), 1) :]
    return Response(
        overshoot=jnp.maximum(way.max(-1) / size[..., 0] - 1.0, 0.0),
        settling=jnp.where(last < n, period * last.astype(float), jnp.inf),
        error=jnp.mean(target - end, axis=-1),
        cycle=0.5 * jnp.ptp(end, axis=-1),
        saturated=jnp.mean((jnp.abs(jnp.asarray(run.command)) >= voltage_limit * (1.0 - 1e-12)).astype(float), axis=-1),
        fastest=jnp.max(jnp.abs(jnp.asarray(run.wheel)), axis=-1),
    )
