"""The command at which the axis breaks loose: what to feed forward against dry friction."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.closed_loop import plant_sign, quasi_static
from rwjax.effects.ports import AxisElastic
from rwjax.errors import InputError
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.dry_friction import friction_level
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

LOWEST, HIGHEST = 1e-6, 1e6
"""Range of commands [V] in which the least that suffices is looked for."""
COMMANDS = 600
"""Commands tried over that range: what a drive gives may fall again with a larger command."""
BISECTIONS = 50
"""Halvings of the interval between the last command that is held and the first that is not."""


def breakaway(rig: Rig) -> float:
    """Least command [V] at which the axis at rest breaks loose towards positive angles.

    The axis stands at angle 0 and its wheel stands. Friction of axis and wheel, a load and a dead zone count, and so do
    friction that grows with the drive's torque, a limited current and what else the plant has, as the run begins.

    Args:
        rig: The rig.

    Returns:
        Command [V]; 0 where the load alone turns the axis that way.

    Raises:
        InputError: As `linearised` does, and where the drive never gives enough torque.
    """
    sign = plant_sign(rig)
    structure, theta = quasi_static(rig)
    commands = np.append(0.0, np.geomspace(LOWEST, HIGHEST, COMMANDS))
    excess = np.asarray(_excess_torque(structure, theta, jnp.asarray(sign * commands)))
    if not np.any(excess > 0.0):
        raise InputError(
            f"the drive never gives the torque at which the axis breaks loose; at its most {-np.max(excess):.3g} N m are missing"
        )
    first = int(np.argmax(excess > 0.0))
    low, high = commands[max(first - 1, 0)], commands[first]
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        enough = float(_excess_torque(structure, theta, jnp.asarray([sign * middle]))[0]) > 0.0
        low, high = (low, middle) if enough else (middle, high)
    return float(low)


@partial(jax.jit, static_argnums=0)
def _excess_torque(structure: Structure, theta: Float[Array, " p"], commands: Float[Array, " c"]) -> Float[Array, " c"]:
    """Torque [N m] on the axis at rest at angle 0 beyond what friction holds against turning forward, by commands [V]."""
    plant, zero, w = one_axis_plant_of(structure, theta), jnp.zeros(()), structure.states.index("w")
    elastic = [
        name for effect in plant.on(AxisElastic) for name in effect.state_names()
    ]  # before it slides, all of it is built up
    rest = tuple(jnp.ones(()) if name in elastic else zero for name in structure.states)

    def one(command: Scalar) -> Scalar:
        volts = plant.act(command)
        rates, torques = plant.with_friction(zero, rest, volts, rest)
        for (body, dry), (free, _) in zip(plant.bodies(), torques, strict=True):
            if body.rate == w:
                return free - friction_level(dry, plant.motion(zero, rest, volts), 1.0)
        return rates[w] * plant.whole_inertia()

    return jax.vmap(one)(commands)
