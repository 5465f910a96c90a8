"""What resists an axis that turns: friction and load, at their most and at their least."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.open_loop import steady_state
from rwjax.effects.ports import AxisDry, AxisElastic, AxisTorque
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.dry_friction import friction_level
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

RATES, ANGLES = 201, 61
"""Rates and angles at which friction and load are looked at."""


def resisting_torque(
    rig: Rig, angle: float, rate: Float[np.ndarray, "..."] | float, drive: float
) -> tuple[np.ndarray, np.ndarray]:
    """Most and least torque of friction and load against an axis that turns from rest, either way.

    Args:
        rig: The rig.
        angle: Angle through which it turns [rad].
        rate: Largest rate on the way [rad/s], `(...)`.
        drive: Torque by which it is driven or braked [N m].

    Returns:
        The most and the least torque [N m], `(...)` each.
    """
    structure, theta, still = steady_state(rig)
    rates = np.linspace(0.0, float(np.max(rate)), RATES)
    both = np.asarray(
        _against(structure, theta, still, jnp.linspace(0.0, angle, ANGLES), jnp.asarray(rates), jnp.asarray(drive))
    )
    upto = np.searchsorted(rates, np.asarray(rate) * (1.0 - 1e-12)).clip(max=RATES - 1)
    most, least = np.maximum.accumulate(both.max(axis=(0, 2))), np.minimum.accumulate(both.min(axis=(0, 2)))
    return np.asarray(most[upto]), np.asarray(least[upto])


@partial(jax.jit, static_argnums=0)
def _against(
    structure: Structure,
    theta: Float[Array, " p"],
    still: Float[Array, " n"],
    angles: Float[Array, " a"],
    rates: Float[Array, " r"],
    drive: Scalar,
) -> Float[Array, "2 r a"]:
    """Torque against the axis [N m], forward and backward."""
    plant, zero = one_axis_plant_of(structure, theta), jnp.zeros(())
    dry = [effect for effect in plant.effects if isinstance(effect, AxisDry | AxisElastic)]
    smooth = [effect for effect in plant.effects if isinstance(effect, AxisTorque)]
    psi, w = (structure.states.index(name) for name in ("psi", "w"))

    def one(way: float, turned: Scalar, rate: Scalar) -> Scalar:
        m = plant.motion(zero, tuple(still.at[psi].set(way * turned).at[w].set(way * rate)), zero)
        torque = sum((effect.torque(m) for effect in smooth), start=zero)
        return friction_level(dry, m._replace(load=drive), way) - way * torque

    ways = [jax.vmap(jax.vmap(partial(one, way), (0, None)), (None, 0))(angles, rates) for way in (1.0, -1.0)]
    return jnp.stack(ways)
