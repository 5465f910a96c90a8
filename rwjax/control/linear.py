"""The rig seen by its controller: the plant linearised about a held angle, and its transfer function without hidden modes."""

from math import comb
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from scipy.linalg import matrix_balance

from rwjax.build import structure_of, theta_of
from rwjax.effects import BY_NAME
from rwjax.effects.drive import DriveLag
from rwjax.effects.ports import CommandDelay, CommandFilter, EncoderDelay
from rwjax.errors import InputError
from rwjax.plant import Plant, friction_level
from rwjax.rig import Rig
from rwjax.simulate import plant_of

SLIDING = 1e-6
"""Rate [rad/s] from which the slope of dry friction is continued to standstill, where it has two."""
CANCELS = 1e-12
"""Share of what a coefficient may be below which it is rounding."""


class Linear(NamedTuple):
    r"""$\dot x = A x + B u$, $y = C x$: command u [V], encoder's angle y [rad]; states that u does not reach or y does not show
    are left out. `delay` [s] from command to reading, on top."""

    states: tuple[str, ...]
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    delay: float


class Transfer(NamedTuple):
    """Polynomials in s of the minimal realisation from command [V] to angle [rad], highest power first, `den` monic.

    `hidden`: poles that no gain moves, the conserved momentum at 0 among them. `sign`: of the command that turns forward.
    """

    num: np.ndarray
    den: np.ndarray
    hidden: tuple[float, ...]

    @property
    def sign(self) -> float:
        return float(np.sign(self.num[0]))


def linearised(rig: Rig, angle: float = 0.0) -> Linear:
    """The rig at rest at an `angle` [rad], no current flowing.

    Dry friction counts as fed forward; its slope beside 0 stays and may be negative, as viscous friction does. What the
    drive does to small commands (dead zone, offset) counts as fed forward, too; its lag stays.
    Raises `InputError` for a rig without an axis and for one whose command does not turn it.
    """
    if rig.kind == "wheel":
        raise InputError("kind `wheel`: there is no axis to hold at an angle; take a `platform` or `reaction` rig")
    structure = structure_of(rig)
    plant = plant_of(structure, jnp.asarray(theta_of(rig, structure)))
    states, zero = structure.states, jnp.zeros(())
    rest = jnp.zeros(len(states)).at[states.index("psi")].set(angle)

    def rates(x: jax.Array, u: jax.Array) -> jax.Array:
        return jnp.stack(plant.field(zero, tuple(x), u))

    def read(x: jax.Array) -> jax.Array:
        return plant.outputs(zero, tuple(x), zero, tuple(x))[structure.outputs.index("yaw_rad")]

    A, B = (np.asarray(d) for d in jax.jacfwd(rates, argnums=(0, 1))(rest, zero))
    C = np.asarray(jax.jacfwd(read)(rest))
    A = A + _slopes(plant, rest)
    for effect in plant.effects:
        if isinstance(effect, DriveLag) and float(effect.T) > 0.0:
            T = float(effect.T)
            A = np.block([[A, B[:, None]], [np.zeros((1, len(A))), -np.ones((1, 1)) / T]])
            B, C, states = np.append(0.0 * B, 1.0 / T), np.append(C, 0.0), (*states, f"{effect.name}:u")
    late = sum((float(d) for d in (plant.delay(), plant.age()) if d is not None), 0.0)
    use = np.flatnonzero(_reached(A, B) & _reached(A.T, C))
    if not len(use):
        raise InputError("the command does not turn the axis; check the rig file's gain")
    return Linear(tuple(states[k] for k in use), A[np.ix_(use, use)], B[use], C[use], late)


def _slopes(plant: Plant, rest: jax.Array) -> np.ndarray:
    """What the slope of dry friction beside standstill adds to the rates' derivatives `(n, n)`."""
    found = np.zeros((len(rest), len(rest)))
    for body, dry in plant.bodies():

        def level(w: jax.Array, body=body, dry=dry) -> jax.Array:
            x = rest.at[body.rate].set(w)
            return friction_level(dry, plant.motion(jnp.zeros(()), tuple(x), jnp.zeros(())), 1.0)

        near, far = (float(jax.grad(level)(jnp.asarray(w))) for w in (SLIDING, 2.0 * SLIDING))
        found[:, body.rate] += np.array([float(r) for r in body.reaction]) * (2.0 * near - far)
    return found


def _reached(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Which states an input reaches through what is not exactly 0."""
    found = B != 0.0
    for _ in range(len(B)):
        found = found | ((A != 0.0) @ found)
    return found


def transfer(linear: Linear) -> Transfer:
    r"""Transfer function of a linearised rig: $\det(sI - A)$ and $\det(sI - A + BC) - \det(sI - A)$, common powers of s left out."""
    fed_back = linear.A - np.outer(linear.B, linear.C)
    den, closed = np.poly(linear.A), np.poly(fed_back)
    rounding = np.maximum(_rounding(linear.A), _rounding(fed_back))
    num, den = (np.where(np.abs(p) > rounding, p, 0.0) for p in (closed - den, den))
    hidden = 0
    while num[-1] == 0.0 and den[-1] == 0.0 and len(den) > 1:
        num, den, hidden = num[:-1], den[:-1], hidden + 1
    return Transfer(np.trim_zeros(num, "f"), den, (0.0,) * hidden)


def _rounding(A: np.ndarray) -> np.ndarray:
    r"""Size of the coefficients of $\det(sI - A)$ that is rounding: a share of what eigenvalues of its size give."""
    size = np.linalg.norm(matrix_balance(A)[0], 2)
    return np.array([CANCELS * comb(len(A), k) * size**k for k in range(len(A) + 1)])


def without_lateness(rig: Rig) -> tuple[str, ...]:
    """Effects of a rig that no transfer function holds: delays and the limit of the drive's rate."""
    late = (CommandDelay, EncoderDelay, CommandFilter)
    return tuple(e for e in rig.effects if issubclass(BY_NAME[e], late) and BY_NAME[e] is not DriveLag)
