"""The linear loop as it runs: sampled, its command held and late, the rig's own delays included."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from rwjax.control.closed_loop import LoopTiming
from rwjax.control.linear import lateness, linearised, transfer
from rwjax.control.region import Loop, sampled_loop, sampled_pid_loop
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig


def running_loops(
    rig: Rig,
    clockwork: LoopTiming,
    smooth: float = 0.0,
    thetas: Float[np.ndarray, "k p"] | None = None,
    angle: float = 0.0,
    integral: bool = False,
) -> list[Loop]:
    """Loops of the rig at an `angle` [rad], or of one plant for each row of `thetas`, each with its own delay; the derivative is
    filtered over `smooth` [s]. Gains `(kp, kd)`, with an `integral` `(kp, ki, kd)`.

    Raises `InputError` as `linearised` and `sampled_loop` do.
    """
    thetas = theta_of(rig, structure_of(rig))[None] if thetas is None else thetas
    plants = transfer(linearised(rig, angle, thetas)).each()
    delays = [clockwork.later(float(late)).lateness for late in lateness(rig, thetas).loop]
    of = sampled_pid_loop if integral else sampled_loop
    return [of(plant, clockwork.period, late, smooth) for plant, late in zip(plants, delays, strict=True)]


def side_by_side(loops: Sequence[Loop]) -> Loop:
    """Sampled loops in one, an axis of plants in front. Those that are less late get poles at z = 0, which change nothing else."""
    order = max(loop.order for loop in loops)
    alike = []
    for base, gains in loops:
        waits = np.poly(np.full(order + 1 - len(base), -1.0))  # a polynomial in z - 1
        alike.append((np.polymul(base, waits), np.stack([np.convolve(row, waits) for row in gains])))
    return Loop(*(np.stack(x) for x in zip(*alike, strict=True)))
