"""The linear loop as it runs: sampled, its command held and delayed, the rig's own delays included."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import expm

from rwjax.control.controller import LoopTiming, split_delay
from rwjax.control.delays import delays_of
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import LoopPolynomial, loop_of_rows, times_variable
from rwjax.control.transfer import Transfer, controller_form, transfer
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig

MOST_PERIODS = 12
"""Longest delay, in periods: rounding would spread the poles at z = 0 of a longer one."""


def sampled_loop(plant: Transfer, period: float, delay: float = 0.0, filter_time: float = 0.0) -> LoopPolynomial:
    r"""PD control at a sampling period, its command held and delayed.

    The derivative is a backward difference behind a first-order filter. The polynomial is one in $z - 1$, which stays well
    conditioned for a short period, where all z lie close to 1.

    Args:
        plant: Transfer function of one plant.
        period: Sampling period [s].
        delay: Time from a reading to its command [s], the rig's own delays included.
        filter_time: Time constant of the derivative's filter [s].

    Returns:
        The loop with gains `(kp, kd)` in V/rad and V s/rad.

    Raises:
        InputError: For a delay of more than `MOST_PERIODS` periods.
    """
    whole, part = split_delay(delay, period)
    if whole > MOST_PERIODS:
        raise InputError(
            f"commands act {delay:g} s after their reading, more than {MOST_PERIODS} periods of {period:g} s; sample less often"
        )
    A, B, C = controller_form(plant)
    step = A @ _integral(A, period)
    new = _integral(A, period - part) @ B  # of the command that comes in during the step
    old = _integral(A, period) @ B - new  # of the one before it
    den, z = np.poly(step), np.ones(2)
    num = np.polyadd(np.polymul(z, _numerator(step, new, C, den)), _numerator(step, old, C, den))
    for _ in range(whole + 1):
        den = np.polymul(den, z)
    slope = np.array([1.0, period / (filter_time + period)])
    rows = [np.polymul(num, slope), np.append(num, 0.0) / (filter_time + period)]
    return loop_of_rows(np.polymul(den, slope), rows)


def sampled_pid_loop(plant: Transfer, period: float, delay: float = 0.0, filter_time: float = 0.0) -> LoopPolynomial:
    """PID control at a sampling period, as `sampled_loop`; the integral is a sum over the samples before.

    Args:
        plant: Transfer function of one plant.
        period: Sampling period [s].
        delay: Time from a reading to its command [s], the rig's own delays included.
        filter_time: Time constant of the derivative's filter [s].

    Returns:
        The loop with gains `(kp, ki, kd)` in V/rad, V/(rad s) and V s/rad.

    Raises:
        InputError: As `sampled_loop` does.
    """
    pd = sampled_loop(plant, period, delay, filter_time)
    rows = [times_variable(pd.gains[0]), period * pd.gains[0], times_variable(pd.gains[1])]
    return loop_of_rows(times_variable(pd.base), rows)


class SampledLaw(NamedTuple):
    """A linear control law as it runs, its gains left open.

    Attributes:
        timing: When it reads and acts, without the rig's own delays.
        filter_time: Time constant of the derivative's filter [s].
        integral: Whether it has an integral: gains `(kp, ki, kd)`, else `(kp, kd)`.
    """

    timing: LoopTiming
    filter_time: float = 0.0
    integral: bool = False


def sampled_loops(
    rig: Rig, law: SampledLaw, thetas: Float[np.ndarray, "k p"] | None = None, angle: float = 0.0
) -> list[LoopPolynomial]:
    """Loops of a rig, or of many plants of its structure, each with its own delay.

    Args:
        rig: The rig.
        law: The control law, its gains left open.
        thetas: Parameter vectors [SI], one plant for each row, `(k, p)`; without them the rig itself counts, k = 1.
        angle: Angle at which the axis is held [rad].

    Returns:
        One loop for each plant.

    Raises:
        InputError: As `linearised` and `sampled_loop` do.
    """
    thetas = theta_of(rig, structure_of(rig))[None] if thetas is None else thetas
    plants = transfer(linearised(rig, angle, thetas)).each()
    delays = [law.timing.with_extra_delay(float(own)).delay for own in delays_of(rig, thetas).loop]
    of = sampled_pid_loop if law.integral else sampled_loop
    return [of(plant, law.timing.period, delay, law.filter_time) for plant, delay in zip(plants, delays, strict=True)]


def stacked_loops(loops: Sequence[LoopPolynomial]) -> LoopPolynomial:
    """Sampled loops in one, with a first axis of plants.

    Loops with a shorter delay get further poles at z = 0, which change nothing else.

    Args:
        loops: One loop for each plant, with the same gains.

    Returns:
        All of them, `base` `(k, n + 1)` and `gains` `(k, g, n + 1)`.
    """
    order = max(loop.order for loop in loops)
    alike = []
    for base, gains in loops:
        wait = np.poly(np.full(order + 1 - len(base), -1.0))  # a polynomial in z - 1
        alike.append((np.polymul(base, wait), np.stack([np.convolve(row, wait) for row in gains])))
    return LoopPolynomial(*(np.stack(x) for x in zip(*alike, strict=True)))


def _integral(A: np.ndarray, time: float) -> np.ndarray:
    """Integral of $e^{A t}$ over a time [s]."""
    n = len(A)
    return time * expm(np.block([[A * time, np.eye(n)], [np.zeros((n, 2 * n))]]))[:n, n:]


def _numerator(A: np.ndarray, B: np.ndarray, C: np.ndarray, den: np.ndarray) -> np.ndarray:
    """Numerator of a plant with one input and one output, from its characteristic polynomial."""
    return np.poly(A - np.outer(B, C)) - den
