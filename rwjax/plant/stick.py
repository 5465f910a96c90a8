"""The end of a step of one body with dry friction that rested or whose speed changed sign."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from rwjax.plant.plant import BodyTorque
from rwjax.types import Scalar


class Stop(NamedTuple):
    """A body at the end of a step.

    Attributes:
        rate: Its speed [rad/s].
        angle: Its angle [rad].
        mended: Whether its speed differs from what the equations of a sliding body give.
    """

    rate: Scalar
    angle: Scalar
    mended: Bool[Array, ""]


def stopped(
    rates: tuple[Scalar, Scalar],
    angles: tuple[Scalar, Scalar],
    rate0: Scalar,
    h: Scalar,
    inertia: Scalar,
    levels: tuple[Scalar, Scalar],
    torques: tuple[BodyTorque, BodyTorque],
) -> Stop:
    """Speed and angle of a body after a step in which it may have stopped, turned, broken away or stayed at rest.

    Args:
        rates: Speed at the beginning, and at the end if it slid all the time [rad/s].
        angles: Angle at the beginning, and at the end if it slid all the time [rad].
        rate0: Acceleration at the beginning [rad/s2].
        h: Length of the step [s].
        inertia: Inertia of the body alone [kg m2].
        levels: Friction forward and backward at rest [N m].
        torques: At both ends of the step, the torque but for its own friction and what it exceeds that by [N m].

    Returns:
        The body at the end of the step.
    """
    (w0, w1), (angle0, angle1) = rates, angles
    (free0, excess0), (free1, excess1) = torques
    forward, backward = levels
    crossed = (w0 * w1 < 0.0) & (forward + backward > 0.0)
    rested = (w0 == 0.0) & (excess0 == 0.0) & (forward + backward > 0.0)
    breaking = rested & (excess1 != 0.0)  # part of the step is over when the torque reaches breakaway

    def within() -> tuple[Scalar, Scalar]:
        # speed over the step: w0 + swift s + bend s^2, with s from 0 to 1; `share` is where it is zero
        swift = h * rate0
        bend = w1 - w0 - swift
        turn = jnp.where(crossed, swift**2 - 4.0 * bend * w0, 1.0)
        share = jnp.where(crossed, 2.0 * w0 / jnp.where(crossed, jnp.sign(w0) * jnp.sqrt(turn) - swift, 1.0), 0.0)
        free = free0 + share * (free1 - free0)
        middle = 0.5 * (free + free1)
        slides = (free > forward) | (free < -backward)
        net = jnp.where(slides, middle - jnp.clip(middle, -backward, forward), 0.0)
        left = (1.0 - share) * h
        turned = left * net / inertia
        spare = jnp.where(
            excess1 > 0.0, forward - free0, backward + free0
        )  # the level, too, may change within the step
        late = spare / jnp.where(breaking, spare + jnp.abs(excess1), 1.0)
        end = jnp.where(breaking, (1.0 - late) * w1, jnp.where(crossed, turned, w1))
        until = share * h * (w0 + share * (swift / 2.0 + share * bend / 3.0))
        through = angle0 + until + 0.5 * left * turned
        away = angle0 + (1.0 - late) * h * end / 3.0
        return end, jnp.where(breaking, away, jnp.where(crossed, through, angle1))

    # a step in which no body turns or breaks away, as most are, does without these
    end, angle = jax.lax.cond(crossed | breaking, within, lambda: (w1, angle1))
    stuck = rested & ~breaking
    return Stop(jnp.where(stuck, 0.0, end), jnp.where(stuck, angle0, angle), crossed | rested)
