"""The slowest pole of a linear closed loop: a plain function of one vector of gains and one plant, of any order.

`jax.jit`, `jax.vmap` and `jax.grad` act on it, and `rwjax.control.over_gains` takes it over many gains and plants. Where it is only
asked on which side of an edge the poles of a PD or PID loop lie, `rwjax.control.stability` is hundreds to thousands of times faster.
"""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from rwjax.control.linear import Linear
from rwjax.control.loop_polynomial import LoopPolynomial
from rwjax.types import Scalar

Law = Callable[[Any, Any], Float[Array, "m m"]]
"""The system matrix of the closed loop [SI], from one vector of gains and one plant."""


def pd_matrix(gains: Float[Array, " 2"], plant: Linear) -> Float[Array, "n n"]:
    r"""System matrix under PD control, $u = -K_p \psi - K_d \dot\psi$.

    Args:
        gains: kp [V/rad] and kd [V s/rad].
        plant: One plant whose command turns forward, so that positive gains restore.

    Returns:
        The matrix [SI].
    """
    kp, kd = gains
    A, B, C = map(jnp.asarray, plant)
    return A - jnp.outer(B, (kp * C + kd * (C @ A)) / (1.0 + kd * (C @ B)))


def pid_matrix(gains: Float[Array, " 3"], plant: Linear) -> Float[Array, "m m"]:
    r"""System matrix under PID control, $u = -K_p \psi - K_i \int \psi - K_d \dot\psi$, the integral its last state.

    Args:
        gains: kp [V/rad], ki [V/(rad s)] and kd [V s/rad].
        plant: One plant whose command turns forward, so that positive gains restore.

    Returns:
        The matrix [SI].
    """
    _, ki, kd = gains
    B, C = jnp.asarray(plant.B), jnp.asarray(plant.C)
    integral = ki * B / (1.0 + kd * (C @ B))
    return jnp.block([[pd_matrix(gains[::2], plant), -integral[:, None]], [C, jnp.zeros(1)]])


def companion(gains: Float[Array, " g"], loop: LoopPolynomial) -> Float[Array, "n n"]:
    """Companion matrix of a loop that is given as a polynomial; of a sampled loop its eigenvalues are z - 1.

    Args:
        gains: One value for each gain of the loop [SI].
        loop: The loop of one plant.

    Returns:
        The matrix [SI].
    """
    c = loop.base + jnp.asarray(gains) @ loop.gains
    return jnp.concatenate([-c[None, 1:] / c[0], jnp.eye(loop.order - 1, loop.order)])


def slowest_pole(gains: Float[Array, " g"], plant: Any, law: Law = pd_matrix) -> Scalar:
    """Largest real part of the poles of a closed loop [1/s]: negative where it is stable.

    Where the slowest poles coincide it has no derivative (two real poles meet with an infinite slope), and its gradient means
    nothing. The two poles of an oscillation do not coincide.

    Args:
        gains: One vector of gains [SI].
        plant: One plant: a `Linear`, or whatever the law takes.
        law: Makes the closed loop's system matrix of both: `pd_matrix`, `pid_matrix`, `companion` or a function of one's own.

    Returns:
        The real part [1/s].
    """
    return jnp.max(jnp.linalg.eigvals(law(gains, plant)).real)


def largest_modulus(gains: Float[Array, " g"], loop: LoopPolynomial) -> Scalar:
    r"""Largest $|z|$ of the poles of a sampled loop [1]: below 1 where it is stable.

    Args:
        gains: One value for each gain of the loop [SI].
        loop: The sampled loop of one plant, a polynomial in z - 1.

    Returns:
        The modulus [1]; a motion of that pole grows at the rate $\ln|z|$ over the sampling period.
    """
    return jnp.max(jnp.abs(1.0 + jnp.linalg.eigvals(companion(gains, loop))))
