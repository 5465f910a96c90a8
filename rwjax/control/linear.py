"""The rig seen by its controller: the plant linearised about a held angle, and its transfer function without hidden modes."""

from functools import partial
from math import comb
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.linalg import matrix_balance

from rwjax.build import structure_of, theta_of
from rwjax.effects import BY_NAME
from rwjax.effects.drive import DriveLag
from rwjax.effects.ports import CommandDelay, CommandFilter, EncoderDelay
from rwjax.errors import InputError
from rwjax.plant import Plant, Structure, friction_level
from rwjax.rig import Rig, with_one_axis
from rwjax.simulate import one_axis_plant_of
from rwjax.types import Scalar

SLIDING = 1e-6
"""Rate [rad/s] from which the slope of dry friction is continued to standstill, where it has two."""
CANCELS = 1e-12
"""Share of what a coefficient may be below which it is rounding."""


class Linear(NamedTuple):
    """One plant, or many of one rig: `A` (…, n, n), `B` (…, n) per V of command, `C` (…, n) of the encoder's angle [rad].

    States that the command does not reach or the encoder does not show are left out. `late` (…,) [s]: the rig's own delays
    between command and reading, on top.
    """

    states: tuple[str, ...]
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    late: np.ndarray


class Transfer(NamedTuple):
    """Polynomials in s of the minimal realisation from command [V] to angle [rad], highest power first along the last axis:
    `num` (…, m), and `den` (…, n), monic.

    `hidden`: poles that no gain moves, a conserved momentum's at 0.
    """

    num: np.ndarray
    den: np.ndarray
    hidden: tuple[float, ...]

    @property
    def restoring(self) -> np.ndarray:
        """Numerator of the plant whose command turns forward (…, m): with it positive gains restore."""
        return self.num * np.sign(self.num[..., :1])


def linearised(rig: Rig, angle: float = 0.0, thetas: Float[np.ndarray, "k p"] | None = None) -> Linear:
    """The rig at rest at an `angle` [rad], no current flowing; or one plant for each row of `thetas`, parameter vectors of its
    structure.

    Dry friction counts as fed forward; its slope beside 0 stays and may be negative, as viscous friction does. What the
    drive does to small commands (dead zone, offset) counts as fed forward, too; its lag stays.
    Raises `InputError` for a rig without an axis and for one whose command does not turn it.
    """
    with_one_axis(rig)
    if rig.kind == "wheel":
        raise InputError("kind `wheel`: there is no axis to hold at an angle; take a `platform` or `reaction` rig")
    structure = structure_of(rig)
    theta = jnp.asarray(theta_of(rig, structure) if thetas is None else thetas)
    A, B, C, late = (np.asarray(x) for x in _matrices(structure, theta, jnp.asarray(angle)))
    states = (*structure.states, *(f"{e}:u" for e in structure.effects if BY_NAME[e] is DriveLag))
    acts, moves, shows = (np.any(x, axis=tuple(range(theta.ndim - 1))) for x in (A, B, C))
    use = _reached(acts, moves) & _reached(acts.T, shows)
    if not use.any():
        raise InputError("the command does not turn the axis; check the rig file's gain")
    k = np.flatnonzero(use)
    return Linear(tuple(states[i] for i in k), A[..., k[:, None], k], B[..., k], C[..., k], late)


@partial(jax.jit, static_argnums=0)
@partial(jnp.vectorize, excluded=(0, 2), signature="(p)->(n,n),(n),(n),()")
def _matrices(structure: Structure, theta: Float[Array, " p"], angle: Scalar) -> tuple[Array, ...]:
    """Derivatives of the rates by state and command and of the encoder's angle by state, and the delays."""
    plant, zero = one_axis_plant_of(structure, theta), jnp.zeros(())
    rest = jnp.zeros(len(structure.states)).at[structure.states.index("psi")].set(angle)

    def rates(x: Array, u: Array) -> Array:
        return jnp.stack(plant.field(zero, tuple(x), u))

    def read(x: Array) -> Array:
        return plant.outputs(zero, tuple(x), zero, tuple(x))[structure.outputs.index("yaw_rad")]

    A, B = jax.jacfwd(rates, argnums=(0, 1))(rest, zero)
    A, C = A + _slopes(plant, rest), jax.jacfwd(read)(rest)
    for lag in (effect for effect in plant.effects if isinstance(effect, DriveLag)):
        fast = 1.0 / jnp.maximum(lag.T, 1e-9)
        A = jnp.block([[A, B[:, None]], [jnp.zeros((1, len(A))), -fast[None, None]]])
        B, C = jnp.append(jnp.zeros_like(B), fast), jnp.append(C, 0.0)
    late = sum((d for d in (plant.delay(), plant.age()) if d is not None), zero)
    return A, B, C, late


def _slopes(plant: Plant, rest: Array) -> Array:
    """What the slope of dry friction beside standstill adds to the rates' derivatives `(n, n)`."""
    found = jnp.zeros((len(rest), len(rest)))
    for body, dry in plant.bodies():

        def level(w: Array, body=body, dry=dry) -> Array:
            x = rest.at[body.rate].set(w)
            return friction_level(dry, plant.motion(jnp.zeros(()), tuple(x), jnp.zeros(())), 1.0)

        near, far = (jax.grad(level)(jnp.asarray(w)) for w in (SLIDING, 2.0 * SLIDING))
        found = found.at[:, body.rate].add(jnp.stack([jnp.asarray(r) for r in body.reaction]) * (2.0 * near - far))
    return found


def _reached(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Which states an input reaches through what is not exactly 0."""
    found = B != 0.0
    for _ in range(len(B)):
        found = found | ((A != 0.0) @ found)
    return found


def transfer(linear: Linear) -> Transfer:
    r"""Transfer function of linearised plants: $\det(sI - A)$ and $\det(sI - A + BC) - \det(sI - A)$, common powers of s left
    out."""
    fed_back = linear.A - linear.B[..., :, None] * linear.C[..., None, :]
    den, closed = characteristic(linear.A), characteristic(fed_back)
    rounding = np.maximum(_rounding(linear.A), _rounding(fed_back))
    num, den = (np.where(np.abs(p) > rounding, p, 0.0) for p in (closed - den, den))
    hidden = 0
    while den.shape[-1] > 1 and not (num[..., -1].any() or den[..., -1].any()):
        num, den, hidden = num[..., :-1], den[..., :-1], hidden + 1
    first = int(np.argmax(np.any(num, axis=tuple(range(num.ndim - 1)))))
    return Transfer(num[..., first:], den, (0.0,) * hidden)


def characteristic(A: Float[np.ndarray, "... n n"]) -> Float[np.ndarray, "... n+1"]:
    r"""Coefficients of $\det(sI - A)$, highest power first."""
    roots = np.linalg.eigvals(A)
    c = np.ones((*A.shape[:-2], 1), complex)
    for k in range(A.shape[-1]):
        zero = np.zeros_like(c[..., :1])
        c = np.concatenate([c, zero], -1) - roots[..., k, None] * np.concatenate([zero, c], -1)
    return np.real(c)


def _rounding(A: Float[np.ndarray, "... n n"]) -> Float[np.ndarray, "... n+1"]:
    r"""Size of the coefficients of $\det(sI - A)$ that is rounding: a share of what eigenvalues of its size give."""
    n = A.shape[-1]
    _, (scale, _) = matrix_balance(A.reshape(-1, n, n)[0], permute=False, separate=True)
    size = np.linalg.norm(A * scale / scale[:, None], 2, axis=(-2, -1))
    return np.stack([CANCELS * comb(n, k) * size**k for k in range(n + 1)], -1)


def without_lateness(rig: Rig) -> tuple[str, ...]:
    """Effects of a rig that no transfer function holds: delays and the limit of the drive's rate."""
    late = (CommandDelay, EncoderDelay, CommandFilter)
    return tuple(e for e in rig.effects if issubclass(BY_NAME[e], late) and BY_NAME[e] is not DriveLag)
