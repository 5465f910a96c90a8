"""Slowing the wheel while the axis's static friction holds the axis: momentum leaves through the bearing."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from rwjax.control.closed_loop import holding
from rwjax.control.open_loop import PIECES, REACHED, Course, Limits, Task, check, fastest, resting, steady, worst
from rwjax.errors import InputError
from rwjax.rig import Rig

MARGIN = 0.9
"""Share of the breakaway torque that a dump uses."""


class Dump(NamedTuple):
    """`bound` [s] below which no command does it, and the `best` course."""

    bound: float
    best: Course

    @property
    def time(self) -> float:
        """Least time on the plant [s]."""
        return float(self.best.time[-1])


def dump(rig: Rig, spin: float, limits: Limits, margin: float = MARGIN) -> Dump:
    r"""Brings the wheel from `spin` [rad/s] to rest in the least time in which the axis does not move.

    While the axis rests, what turns the wheel pushes back on the axis: $|J\dot\Omega| \le \mu M_s$ less the load that the axis
    bears, so $T \ge J\Omega_0/(\mu M_s)$, with $\mu$ the `margin`, the share of the breakaway torque that is used.
    Raises `InputError` for a rig without a wheel, limits that are not positive, and an axis that friction does not hold.
    """
    check(rig, limits)
    if spin == 0.0 or not np.isfinite(spin):
        raise InputError(f"wheel at {spin:g} rad/s: has to be a number other than 0")
    if not 0.0 < margin <= 1.0:
        raise InputError(f"margin {margin:g}: has to lie above 0 and not above 1")
    structure, theta, start = steady(rig, spin)
    K, R, J = (rig.values[n] for n in ("motor.torque_constant", "motor.resistance", "wheel.inertia"))
    before = resting(rig, spin)
    load, (backward, forward) = float(before.torque), (margin * float(v) for v in before.holds)
    room = forward - load if spin > 0.0 else backward + load
    if room <= 0.0:
        raise InputError("nothing holds the axis while the wheel slows: the rig has no dry friction left for it")
    bound = J * abs(spin) / room

    Omega = spin * np.linspace(1.0, 0.0, PIECES + 1)
    guess = holding(rig.values) * Omega - R / K * np.sign(spin) * 0.9 * room
    numbers = jnp.array([spin, K / room, margin, room])
    task = Task(theta, limits, numbers, start, bound / 0.9, 1.0)
    best, missed = fastest(structure, _stopped if structure.inductive else _slowed, PIECES, task, guess)
    if not missed <= REACHED:  # nor where it is no number
        raise InputError(f"no dump from {spin:g} rad/s was found within these limits; raise the voltage or the current")
    return Dump(bound, best)


def _slowed(found: Course, numbers: Array) -> tuple[Array, Array]:
    """The wheel stands, and friction held the axis all the while."""
    spin, _, margin, room = numbers
    within = (margin * found.holds[:, 0] + found.torque, margin * found.holds[:, 1] - found.torque)
    return found.wheel[-1:] / spin, jnp.concatenate([worst(w / room) for w in within])


def _stopped(found: Course, numbers: Array) -> tuple[Array, Array]:
    """And no current is left that would turn it again."""
    zero, positive = _slowed(found, numbers)
    return jnp.append(zero, numbers[1] * found.current[-1]), positive
