r"""One time step: the linear part exactly, the rest to second order, dry friction with exact stick.

With $A$ the Jacobian of the plant's smooth field at rest and $N(x) = f(x) - A x$,

$a = e^{hA} x + h\varphi_1(hA) N(x), \qquad x^+ = a + h\varphi_2(hA)\,[N(a) - N(x)]$

(exponential Runge-Kutta of second order; Cox and Matthews, J. Comput. Phys. 176 (2002), eq. 22), so that a linear plant,
a short electrical time constant included, is solved exactly under a held input. Dry friction adds to $f$: a sliding body
feels its level against the direction in which it slid at the start of the step; a resting body feels exactly the
friction that keeps it at rest, up to its breakaway level. A body whose speed changes sign within the step stops at the
zero crossing and goes on from there for the rest of the step, or stays. There is no smoothed sign and no width.
"""

from functools import cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from rwjax.plant.assemble import AnyPlant, assemble
from rwjax.plant.one_axis import Body, Plant, State, Structure, friction_level
from rwjax.plant.two_axis import TwoAxis
from rwjax.simulation.coupled import stop_or_turn_together, with_coupled_friction
from rwjax.simulation.stick import stopped
from rwjax.types import Scalar

Command = Float[Array, "*channels"]
"""What acts on a plant: one voltage, or one for each axis of a rig with two."""
TAYLOR_TERMS = 10
SQUARINGS = 10  # h*|A| up to 2**10 / 4, e.g. an electrical time constant of 20 us in steps of 5 ms


Matrix = tuple[tuple[Scalar, ...], ...]
"""Rows of entries, each an array of its own: of many plants side by side a step reads an entry's values in one piece."""


class Propagator(NamedTuple):
    """The linear part and its exponential functions for one step length."""

    A: Matrix
    E: Matrix
    phi1: Matrix
    phi2: Matrix


def propagator(plant: AnyPlant, h: Scalar) -> Propagator:
    r"""$e^{hA}$, $h\varphi_1(hA)$ and $h\varphi_2(hA)$ by scaling and doubling."""
    n = len(plant.structure.states)
    A = _smooth_jacobian(plant)
    z = A * (h / 2.0**SQUARINGS)
    eye = jnp.eye(n)
    # phi2(z) = sum z^k / (k+2)!, then phi1 = I + z phi2 ... by their recurrence
    phi2 = eye
    for k in range(TAYLOR_TERMS, 0, -1):
        phi2 = eye + (z @ phi2) / (k + 2.0)
    phi2 = phi2 / 2.0
    phi1 = eye + z @ phi2
    E = eye + z @ phi1

    def double(_: Int[Array, ""], p: tuple) -> tuple:
        E, phi1, phi2 = p
        return E @ E, (E @ phi1 + phi1) / 2.0, (E @ phi2 + phi1 + phi2) / 4.0

    E, phi1, phi2 = jax.lax.fori_loop(0, SQUARINGS, double, (E, phi1, phi2))
    return Propagator(*(tuple(tuple(row) for row in M) for M in (A, E, h * phi1, h * phi2)))


def _smooth_jacobian(plant: AnyPlant) -> Float[Array, "n n"]:
    n = len(plant.structure.states)
    zero = jnp.zeros(())
    no_command = jnp.zeros(2) if isinstance(plant, TwoAxis) else zero

    def smooth(x: Float[Array, " n"]) -> Float[Array, " n"]:
        return jnp.stack(plant.field(zero, tuple(x[k] for k in range(n)), no_command))

    return jax.jacfwd(smooth)(jnp.zeros(n))


@cache
def _couplings(structure: Structure) -> tuple[np.ndarray, np.ndarray]:
    """Which entries of the linear part, and of its exponential, can differ from zero: the others are not computed."""
    generic = {name: 0.7 + 0.1 * k for k, name in enumerate(structure.names)}
    with jax.ensure_compile_time_eval():
        A = np.asarray(jax.jit(lambda numbers: _smooth_jacobian(assemble(structure, numbers)))(generic)) != 0.0
    n = len(A)
    return A, np.linalg.matrix_power(np.eye(n, dtype=int) + A, n) > 0


def _times(M: Matrix, x: State, used: np.ndarray) -> State:
    return tuple(
        sum((M[r][c] * x[c] for c in np.flatnonzero(used[r])), start=jnp.zeros_like(x[r])) for r in range(len(x))
    )


def _add(x: State, y: State) -> State:
    return tuple(a + b for a, b in zip(x, y, strict=True))


def _minus(x: State, y: State) -> State:
    return tuple(a - b for a, b in zip(x, y, strict=True))


def with_friction(
    plant: AnyPlant, t: Scalar, x: State, u: Command, start: State
) -> tuple[State, list[tuple[Scalar, Scalar]]]:
    """Rates of the state with dry friction, and for each body the torque free of its friction and the excess over it.

    The direction of sliding is that of `start`, the state at the beginning of the step.
    """
    if isinstance(plant, TwoAxis):
        return with_coupled_friction(plant, t, x, u, start)
    rates = plant.field(t, x, u)
    motion = plant.motion(t, x, u)
    torques = []
    for body, effects in plant.bodies():
        free = rates[body.rate] * body.inertia
        forward, backward = friction_level(effects, motion, 1.0), friction_level(effects, motion, -1.0)
        w = start[body.rate]
        holding = jnp.clip(free, -backward, forward)
        friction = jnp.where(w > 0.0, forward, jnp.where(w < 0.0, -backward, holding))
        rates = tuple(r + c * friction for r, c in zip(rates, body.reaction, strict=True))
        torques.append((free, free - holding))
    return rates, torques


def _stop_or_turn(
    plant: Plant,
    body: Body,
    effects: list,
    t: Scalar,
    x: State,
    x1: State,
    u: Scalar,
    h: Scalar,
    rate0: Scalar,
    torques: list,
) -> State:
    """Mend the end of a step for a body that rested or whose speed changed sign."""
    rest = plant.motion(t, tuple(jnp.zeros_like(v) if k == body.rate else v for k, v in enumerate(x)), u)
    levels = friction_level(effects, rest, 1.0), friction_level(effects, rest, -1.0)
    rates, angles = (x[body.rate], x1[body.rate]), (x[body.angle], x1[body.angle])
    end, angle, _ = stopped(rates, angles, rate0, h, body.inertia, levels, torques)
    impulse = (end - x1[body.rate]) / body.reaction[body.rate]
    mended = [v + c * impulse for v, c in zip(x1, body.reaction, strict=True)]
    mended[body.rate], mended[body.angle] = end, angle
    return tuple(mended)


def step(plant: AnyPlant, p: Propagator, t: Scalar, x: State, u: Command, h: Scalar) -> State:
    """State after one step of length `h` [s] under the mean command `u` [V] of the step."""
    return _mended(plant, p, t, x, u, h, x, len(x))


def sliding_step(plant: Plant, p: Propagator, t: Scalar, x: State, u: Scalar, h: Scalar, way: Scalar) -> State:
    """`step` of an axis that slides `way` (1 or -1) whatever its speed: dry friction neither holds it nor turns with it, so
    that the state is smooth in the commands that bring it to rest."""
    w = plant.structure.states.index("w")
    return _mended(plant, p, t, x, u, h, (*x[:w], way, *x[w + 1 :]), w)


def _mended(
    plant: AnyPlant, p: Propagator, t: Scalar, x: State, u: Command, h: Scalar, start: State, slides: int
) -> State:
    """A step in the directions of sliding of `start`; bodies stop or turn, but for the one whose rate is at index `slides`."""
    direct, reached = _couplings(plant.structure)
    rates0, torques0 = with_friction(plant, t, x, u, start)
    n0 = _minus(rates0, _times(p.A, x, direct))
    a = plant.deflected(x, _add(_times(p.E, x, reached), _times(p.phi1, n0, reached)), h)
    rates1, torques1 = with_friction(plant, t + h, a, u, start)
    n1 = _minus(rates1, _times(p.A, a, direct))
    x1 = _add(a, _times(p.phi2, _minus(n1, n0), reached))
    if isinstance(plant, TwoAxis):
        x1 = stop_or_turn_together(plant, t, x, x1, u, h, rates0, list(zip(torques0, torques1, strict=True)))
        return plant.within_limits(plant.deflected(x, x1, h))
    for k, (body, effects) in enumerate(plant.bodies()):
        if body.rate != slides:
            x1 = _stop_or_turn(plant, body, effects, t, x, x1, u, h, rates0[body.rate], [torques0[k], torques1[k]])
    return plant.within_limits(plant.deflected(x, x1, h))
