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
    """Plants of some order with some zeros, their states mixed by a random rotation, poles and zeros on both sides of 0."""
    den = np.array([_polynomial(rng, order, -0.3) for _ in range(count)])
    num = np.array([_polynomial(rng, zeros, -2.0) for _ in range(count)]) * np.exp(rng.normal(0.0, 1.0, (count, 1)))
    A = np.zeros((count, order, order))
    A[:, 0], A[:, 1:, :-1] = -den[:, 1:], np.eye(order - 1)
    B, C = np.eye(order)[0], np.pad(num, ((0, 0), (order - 1 - zeros, 0)))
    Q = np.linalg.qr(rng.normal(size=A.shape))[0]
    plants = Linear(Q @ A @ Q.swapaxes(1, 2), Q @ B, np.squeeze(C[:, None] @ Q.swapaxes(1, 2), 1))
    return Loops(plants, transfer(plants), np.exp(rng.normal(1.0, 1.0, (count, 2))), 0.2)


def _polynomial(rng: np.random.Generator, order: int, middle: float) -> np.ndarray:
    """A monic polynomial: its roots scatter about a real part, half of the pairs complex."""
    roots = rng.normal(middle, 1.0, order).astype(complex)
    for k in range(0, order - 1, 2):
        if rng.random() < 0.5:
            roots[k] += 1j * rng.exponential(2.0)
            roots[k + 1] = np.conj(roots[k])
    return np.atleast_1d(np.poly(roots).real)


FAMILIES = {
    "order 2": lambda rng, count: of_order(rng, count, 2, 0),
    "order 3, the thesis's rig": thesis_axes,
    "order 4, one zero": lambda rng, count: of_order(rng, count, 4, 1),
    "order 4, two zeros": lambda rng, count: of_order(rng, count, 4, 2),
    "order 5, two zeros": lambda rng, count: of_order(rng, count, 5, 2),
    "order 5, three zeros": lambda rng, count: of_order(rng, count, 5, 3),
}
