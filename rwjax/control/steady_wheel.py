"""A rig whose axis rests while its wheel turns steadily: the state, and the command that keeps it."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.optimize import root

from rwjax.control.controller import wheel_holding_voltage
from rwjax.control.drive_limits import turning
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import AxisAgeing, AxisElastic, Coupling
from rwjax.errors import RigError
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

STEPS = 50
"""Most steps to the command of which the drive makes a voltage."""
EXACT = 1e-12
"""Relative error of the state [1]."""


class SteadyWheel(NamedTuple):
    """A rig whose axis rests while its wheel turns steadily.

    Attributes:
        structure: Structure of its plant.
        theta: Parameter vector, `(p,)` [SI].
        state: State in the structure's order, `(n,)` [SI].
        command: Command that keeps the wheel's rate [V].
    """

    structure: Structure
    theta: Float[Array, " p"]
    state: Float[Array, " n"]
    command: float


def steady_wheel(rig: Rig, spin: float = 0.0) -> SteadyWheel:
    """State and command of a rig whose wheel has turned steadily for so long that the effects' own states have settled.

    The rates of the wheel, of the current and of these states are all 0. A wheel that stands does so without a command.

    Args:
        rig: The rig.
        spin: Wheel rate [rad/s].

    Returns:
        The rig so.

    Raises:
        RigError: No command keeps that rate, such as where the winding warms without end.
    """
    structure = structure_of(rig)
    theta = jnp.asarray(theta_of(rig, structure))
    if spin == 0.0:
        return SteadyWheel(structure, theta, jnp.zeros(len(structure.states)), 0.0)
    current = rig.values.get("motor.friction", 0.0) * spin / rig.values["motor.torque_constant"]
    solved = _solved(structure)
    first = [float(wheel_holding_voltage(rig.values)) * spin, *(current if name == "i" else 0.0 for name in solved)]
    found = _balanced(structure, theta, spin, np.array(first))
    if found is None:
        own = dict.fromkeys(name.partition(":")[0] for name in solved if ":" in name)
        why = (
            f"{' and '.join(own)} may not settle there" if own else "its motor does not give what friction takes there"
        )
        raise RigError(
            f"no command keeps the wheel at {turning(spin)}: {why}; take a lower rate, or check these numbers"
        )
    state = _state(structure, spin, jnp.asarray(found))
    return SteadyWheel(structure, theta, state, _command(structure, theta, float(found[0])))


def _solved(structure: Structure) -> list[str]:
    """States that are solved for: the current, and what effects carry along that has a rate of its own while the axis rests."""
    return [
        name
        for name in structure.states
        if name == "i"
        or (":" in name and not issubclass(BY_NAME[name.partition(":")[0]], AxisElastic | AxisAgeing | Coupling))
    ]


def _state(structure: Structure, spin: Scalar | float, unknown: Float[Array, " u"]) -> Float[Array, " n"]:
    """The state by voltage and `_solved` states."""
    given = {"Omega": jnp.asarray(spin)} | dict(zip(_solved(structure), unknown[1:], strict=True))
    return jnp.stack([given.get(name, jnp.zeros(())) for name in structure.states])


@partial(jax.jit, static_argnums=0)
def _rates(
    structure: Structure, theta: Float[Array, " p"], spin: Scalar | float, unknown: Float[Array, " u"]
) -> tuple[Float[Array, " u"], Float[Array, "u u"]]:
    """Rates of the wheel and of the `_solved` states, dry friction included, and their derivative by voltage and these states."""
    plant = one_axis_plant_of(structure, theta)
    rows = jnp.array([structure.states.index(name) for name in ("Omega", *_solved(structure))])

    def rates(unknown: Float[Array, " u"]) -> Float[Array, " u"]:
        x = tuple(_state(structure, spin, unknown))
        return jnp.stack(plant.with_friction(jnp.zeros(()), x, unknown[0], x).rates)[rows]

    return rates(unknown), jax.jacfwd(rates)(unknown)


def _balanced(structure: Structure, theta: Float[Array, " p"], spin: float, unknown: np.ndarray) -> np.ndarray | None:
    """Voltage and states at which nothing changes, from a first guess; None where there is none, or it is not stable."""

    def rates(unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        value, slope = _rates(structure, theta, spin, jnp.asarray(unknown))
        return np.asarray(value), np.asarray(slope)

    found = root(rates, unknown, jac=True, tol=EXACT)
    left, slope = rates(found.x)
    still = np.all(np.abs(left) <= np.sqrt(EXACT) * (1.0 + np.abs(slope) @ np.abs(found.x)))
    return found.x if still and np.linalg.cond(slope) < np.inf and _settles(structure, slope) else None


def _settles(structure: Structure, slope: np.ndarray) -> bool:
    """Whether the effects' own states come back while voltage and current keep the wheel's rate."""
    own = np.array([False, *(":" in name for name in _solved(structure))])
    kept = slope[np.ix_(~own, ~own)]
    back = slope[np.ix_(own, own)] - slope[np.ix_(own, ~own)] @ np.linalg.solve(kept, slope[np.ix_(~own, own)])
    return bool(np.all(np.linalg.eigvals(back).real <= 0.0))


def _command(structure: Structure, theta: Float[Array, " p"], volts: float) -> float:
    """The command [V] of which the drive makes this voltage [V], or comes as near as it does in `STEPS`."""
    command = volts
    for _ in range(STEPS):
        made, slope = map(float, _acted(structure, theta, command))
        if made == volts:
            break
        command += (volts - made) / (slope if slope > 0.0 else 1.0)
    return command


@partial(jax.jit, static_argnums=0)
def _acted(structure: Structure, theta: Float[Array, " p"], command: Scalar | float) -> tuple[Scalar, Scalar]:
    """What a command acts as [V], and its derivative."""
    return jax.value_and_grad(one_axis_plant_of(structure, theta).act)(jnp.asarray(command))
