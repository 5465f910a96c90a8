"""Random plants with random PD gains: the thesis's axis with other numbers, and plants of any order."""

from typing import NamedTuple

import numpy as np

from experiments.control.problem import rig
from rwjax.control.linear import Linear, linearised
from rwjax.control.transfer import Transfer, transfer
from rwjax.plant.from_rig import structure_of, theta_of


class Loops(NamedTuple):
    """Plants `(k, …)` with a pair of gains each, `(k, 2)`, and how far left of 0 their poles are wanted [1/s]."""

    plants: Linear
    transfers: Transfer
    gains: np.ndarray
    sigma: float


def thesis_axes(rng: np.random.Generator, count: int) -> Loops:
    """The thesis's testbed, each of its numbers multiplied by a factor of its own; some with falling friction.

    The closed form gets the library's linearised rig. The plants are written out by hand in the three states angle, wheel rate and
    current, the momentum I psi' + friction psi + J Omega = 0 put in.
    """
    own = rig(dry=False)
    structure = structure_of(own)
    thetas = theta_of(own, structure) * np.exp(rng.normal(0.0, 0.3, (count, len(structure.names))))
    slope = structure.names.index("axis.friction.viscous")
    thetas[:, slope] *= rng.choice([-1.0, 1.0], count)
    names = ("axis.inertia", "axis.friction.viscous", "wheel.inertia", "motor.friction", "motor.torque_constant")
    I, c, J, b, K = (thetas[:, structure.names.index(name)] for name in names)
    R, L = (thetas[:, structure.names.index(f"motor.{name}")] for name in ("resistance", "inductance"))
    zero = np.zeros(count)
    A = np.moveaxis(np.array([[-c / I, -J / I, zero], [zero, -b / J, K / J], [zero, -K / L, -R / L]]), -1, 0)
    B, C = np.stack([zero, zero, 1.0 / L], -1), np.tile([-1.0, 0.0, 0.0], (count, 1))
    gains = rng.uniform(0.0, 100.0, (count, 2))
    return Loops(Linear(A, B, C), transfer(linearised(own, thetas=thetas)), gains, 0.5)


def of_order(rng: np.random.Generator, count: int, order: int, zeros: int) -> Loops:
    """Plants of some order with some zeros: the angle and its derivatives up to that which the command drives, and inner states that
    follow the angle and act back. Poles lie on both sides of 0, and so do a few zeros."""
    chain = order - zeros
    A = np.zeros((count, order, order))
    A[:, range(chain - 1), range(1, chain)] = 1.0
    A[:, chain - 1] = rng.normal(-1.0, 2.0, (count, order))
    A[:, chain:, 0] = rng.normal(size=(count, zeros))
    A[:, chain:, chain:] = rng.normal(size=(count, zeros, zeros)) - 2.0 * np.eye(zeros)
    B = np.exp(rng.normal(size=(count, 1))) * np.eye(order)[chain - 1]
    plants = Linear(A, B, np.tile(np.eye(order)[0], (count, 1)))
    return Loops(plants, transfer(plants), np.exp(rng.normal(1.0, 1.0, (count, 2))), 0.2)


FAMILIES = {
    "order 2": lambda rng, count: of_order(rng, count, 2, 0),
    "order 3, the thesis's rig": thesis_axes,
    "order 4, one zero": lambda rng, count: of_order(rng, count, 4, 1),
    "order 4, two zeros": lambda rng, count: of_order(rng, count, 4, 2),
    "order 5, two zeros": lambda rng, count: of_order(rng, count, 5, 2),
    "order 5, three zeros": lambda rng, count: of_order(rng, count, 5, 3),
}
