"""The rig as its controller sees it: the plant linearised about a held angle, hidden modes left out."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.effects.effect import Effect
from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import SLIDING, CommandDelay, CommandFilter, Dry, EncoderDelay
from rwjax.errors import RigError
from rwjax.logs.driven import driven_by
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.dry_friction import friction_sum
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig, with_one_axis
from rwjax.types import Scalar

CANCELS = 1e-13
"""Share of what a number is summed from, or of what it is one radian on, below which it is rounding."""


class Linear(NamedTuple):
    r"""State space of one plant, or of many of one rig, $\dot x = A x + B u$, $\psi = C x$.

    A PyTree of arrays. Of a rig, states that the command does not reach or the encoder does not show are left out, and so
    are delays.

    Attributes:
        A: System matrix [SI], `(..., n, n)`.
        B: Input matrix, per volt of command [SI], `(..., n)`.
        C: Output matrix, of the encoder's angle [rad], `(..., n)`.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray


def linearised(rig: Rig, angle: float = 0.0, thetas: Float[np.ndarray, "k p"] | None = None) -> Linear:
    """A rig linearised at rest at an angle, no current flowing; or many plants of its structure.

    Dry friction counts as fed forward. Its slope beside standstill stays and may be negative, as viscous friction may. What the
    drive does to small commands (dead zone, offset) counts as fed forward too; its lag stays. Backlash counts as closed, and
    no ripple of the motor holds the wheel. Friction that builds up over a displacement is built up: the axis slides. What
    changes over a run is as it begins.

    Args:
        rig: The rig.
        angle: Angle at which the axis is held [rad].
        thetas: Parameter vectors [SI], one plant for each row, `(k, p)`; without them the rig itself counts.

    Returns:
        Matrices of the plant, those of many with a first axis of k.

    Raises:
        RigError: For a rig without an axis, for one whose command does not turn it, and for a joint whose rig file lacks
            what turns a voltage into torque.
    """
    with_one_axis(rig)
    if rig.kind == "wheel":
        raise RigError(
            "kind `wheel`: there is no axis to hold at an angle; take a `platform`, `reaction` or `joint` rig"
        )
    rig = driven_by(rig, "voltage_V")
    whole = structure_of(rig)
    structure, theta = _linear_plant(whole, theta_of(rig, whole) if thetas is None else np.asarray(thetas))
    lags = _lags(structure, theta)
    A, B, C = (np.asarray(x) for x in _matrices(structure, lags, jnp.asarray(theta), jnp.asarray(angle)))
    elsewhere = np.asarray(_matrices(structure, lags, jnp.asarray(theta), jnp.asarray(angle + 1.0))[0])
    A = np.where(np.abs(A) > CANCELS * np.abs(elsewhere), A, 0.0)  # a load's slope at its summit is rounding
    acts, moves, shows = (np.any(x, axis=tuple(range(theta.ndim - 1))) for x in (A, B, C))
    use = _reached(acts, moves) & _reached(acts.T, shows)
    if not use.any():
        raise RigError("the command does not turn the axis; check the rig file's gain")
    k = np.flatnonzero(use)
    return Linear(A[..., k[:, None], k], B[..., k], C[..., k])


def _linear_plant(structure: Structure, theta: np.ndarray) -> tuple[Structure, np.ndarray]:
    """Structure and numbers of the plant for small motions about its angle, each effect replaced by what stands for it."""
    kept = {new: name for name in structure.effects if (new := _stands_for(structure, theta, name))}
    found = structure._replace(effects=()).with_effects(*kept)
    of = {name: name for name in structure.numbers} | {
        f"{new}.{number}": f"{old}.{number}" for new, old in kept.items() for number in parameters(BY_NAME[new])
    }
    theta = theta[..., [structure.names.index(of[name]) for name in found.names]]
    held = {f"{name}.{number}": value for name in kept for number, value in BY_NAME[name].linear_numbers.items()}
    return found, np.where([name in held for name in found.names], [held.get(name, 0.0) for name in found.names], theta)


def _stands_for(structure: Structure, theta: np.ndarray, name: str) -> str:
    """Name of the effect that stands for an effect in the linearised plant, "" for none."""
    effect = BY_NAME[name]
    if issubclass(effect, CommandFilter) and effect.linear and not effect.order(_numbers(structure, theta, name)):
        return ""
    return name if effect.linear_as is None else effect.linear_as


def _numbers(structure: Structure, theta: np.ndarray, name: str) -> dict[str, np.ndarray]:
    """Numbers of an effect by name `(…)`, of one plant or of several."""
    return {number: theta[..., structure.names.index(f"{name}.{number}")] for number in parameters(BY_NAME[name])}


def _lags(structure: Structure, theta: np.ndarray) -> tuple[tuple[str, int], ...]:
    """The filters between command and voltage, each with its order: the number of lags in a row."""
    filters = [(name, e) for name in structure.effects if issubclass(e := BY_NAME[name], CommandFilter)]
    return tuple((name, e.order(_numbers(structure, theta, name))) for name, e in filters)


@partial(jax.jit, static_argnums=(0, 1))
@partial(jnp.vectorize, excluded=(0, 1, 3), signature="(p)->(n,n),(n),(n)")
def _matrices(
    structure: Structure, lags: tuple[tuple[str, int], ...], theta: Float[Array, " p"], angle: Scalar
) -> tuple[Array, ...]:
    """Derivatives of the rates by state and command and of the encoder's angle by state."""
    plant, zero = one_axis_plant_of(structure, theta), jnp.zeros(())
    rest = jnp.zeros(len(structure.states)).at[structure.states.index("psi")].set(angle)

    def rates(x: Array, u: Array) -> Array:
        return jnp.stack(plant.field(zero, tuple(x), u))

    def read(x: Array) -> Array:
        return plant.outputs(zero, tuple(x), zero, tuple(x))[structure.outputs.index("yaw_rad")]

    A, B = jax.jacfwd(rates, argnums=(0, 1))(rest, zero)
    A, C = A + _slopes(plant, rest), jax.jacfwd(read)(rest)
    for effect, (_, order) in zip(plant.on(CommandFilter), lags, strict=True):
        for T in effect.lags(order):  # the first one drives the plant
            fast = 1.0 / T
            A = jnp.block([[A, B[:, None]], [jnp.zeros((1, len(A))), -fast[None, None]]])
            B, C = jnp.append(jnp.zeros_like(B), fast), jnp.append(C, 0.0)
    return A, B, C


def _slopes(plant: OneAxis, rest: Array) -> Array:
    """What the slope of dry friction beside standstill adds to the rates' derivatives `(n, n)`."""
    found = jnp.zeros((len(rest), len(rest)))
    for body, dry in plant.bodies():
        flat = [effect.beside_standstill() for effect in dry]
        steep = jnp.any(jnp.stack([jnp.zeros((), bool), *(effect.steep() for effect in dry)]))

        def level(w: Array, body=body, flat=flat) -> Array:
            x = rest.at[body.rate].set(w)
            return friction_sum(flat, plant.motion(jnp.zeros(()), tuple(x), jnp.zeros(())), 1.0)

        near, far = (jax.grad(level)(jnp.asarray(w)) for w in (SLIDING, 2.0 * SLIDING))
        slope = jnp.where(steep, near, 2.0 * near - far)
        found = found.at[:, body.rate].add(jnp.stack([jnp.asarray(r) for r in body.reaction]) * slope)
    return found


def _reached(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Which states an input reaches through what is not exactly 0."""
    found = B != 0.0
    for _ in range(len(B)):
        found = found | ((A != 0.0) @ found)
    return found


def _is_lags(effect: type[Effect]) -> bool:
    """Whether an effect is a linear filter, lags in a row, which a transfer function holds."""
    return issubclass(effect, CommandFilter) and effect.linear


def left_out_effects(rig: Rig, sampled: bool = False) -> tuple[str, ...]:
    """Effects of a rig that no transfer function holds: a limit of the drive's rate, and delays.

    Args:
        rig: The rig.
        sampled: Whether the loop is sampled, which holds delays.

    Returns:
        Names of the effects.
    """
    late = (CommandFilter,) if sampled else (CommandDelay, EncoderDelay, CommandFilter)
    return tuple(e for e in rig.effects if issubclass(BY_NAME[e], late) and not _is_lags(BY_NAME[e]))


def linearisation_notes(rig: Rig) -> tuple[str, ...]:
    """What stands in the transfer function for effects of a rig that it cannot hold.

    Args:
        rig: The rig.

    Returns:
        A line for each such effect.
    """
    effects = [(BY_NAME[name], given) for name, given in rig.effects.items()]
    effects.sort(key=lambda effect: not effect[0].linear_note({}))  # what is said of any numbers comes first
    notes = [(e.name, e.linear_note(given)) for e, given in effects]
    notes += [(e.name, e.slope_note(given)) for e, given in effects if issubclass(e, Dry)]
    return tuple(f"{name}: {words}" for name, words in notes if words)
