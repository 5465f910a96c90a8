r"""A rig as a python-control plant: a Python file with its matrices, and the slope of dry friction over the amplitude.

Dry friction has no slope at standstill. For an oscillation with the rate $a\sin\theta$ its describing function is

$$N(a) = \frac{2}{\pi a}\int_0^\pi F(a\sin\theta)\sin\theta\,d\theta,$$

where $F$ is the friction's level [N m]. For a constant level it is $4F/(\pi a)$. It enters the plant as viscous friction does.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from rwjax.control.linear import Linear, left_out_effects, linearisation_notes, linearised
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import AxisElastic, Dry
from rwjax.errors import RigError
from rwjax.export import Exported
from rwjax.export.instead import AS_JOINT
from rwjax.export.template import rendered
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.dry_friction import friction_level
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig

TEMPLATE = "plant.py.j2"
VISCOUS = "axis.friction.viscous"
DRY = tuple(f"axis.friction.{name}" for name in ("coulomb", "static", "stribeck_velocity", "b3", "b2", "b1", "b0"))
"""Numbers of the rig file that describe dry friction of the axis, or a level over the rate."""
AMPLITUDES = np.geomspace(1e-3, 1e2, 51)
"""Amplitudes of the rate for which the slope is worked out [rad/s]."""
ANGLES = 1000
"""Points of the integral over half a period."""


def python_control(rig: Rig) -> Exported:
    """A rig linearised at rest at angle 0, as a Python file that makes a `control.ss`.

    Args:
        rig: A rig with one axis; the plant is from the voltage to the angle, without a servo's loop.

    Returns:
        The file, and what it does not hold.

    Raises:
        RigError: For a rig without an axis, or whose command does not turn its axis (`rwjax.control.linear.linearised`).
    """
    if rig.kind == "wheel":
        raise RigError(f"kind `wheel` has no axis whose angle the plant could give; {AS_JOINT}")
    smooth = _without_dry_friction(rig)
    plant = linearised(smooth)
    damped = linearised(replace(smooth, numbers=smooth.numbers | {VISCOUS: smooth.numbers.get(VISCOUS, 0.0) + 1.0}))
    text = rendered(
        TEMPLATE,
        kind=rig.kind,
        name=rig.name,
        A=plant.A.tolist(),
        B=plant.B[:, None].tolist(),
        C=plant.C[None, :].tolist(),
        per_damping=(damped.A - plant.A).tolist(),
        amplitudes=AMPLITUDES.tolist(),
        levels=(AMPLITUDES * describing_function(rig, AMPLITUDES)).tolist(),
    )
    return Exported(text, _left_out(rig, smooth, plant))


def _left_out(rig: Rig, smooth: Rig, plant: Linear) -> dict[str, str]:
    """What neither the matrices hold nor the describing function."""
    left = {"drive.servo": "the plant is that behind the loop"} if rig.servo is not None else {}
    late = left_out_effects(rig)
    notes = dict(note.split(": ", 1) for note in linearisation_notes(smooth))
    for name, given in rig.effects.items():
        effect = BY_NAME[name]
        if issubclass(effect, Dry):
            if not effect.c_level(given) or issubclass(effect, AxisElastic):
                left[name] = "its dry friction is no function of the axis's rate alone"
        elif name in late:
            left[name] = "no transfer function holds it; `control.pade` stands for a delay"
        elif name in notes:
            left[name] = notes[name]
        elif _changes_nothing(smooth, name, plant):
            left[name] = "it counts as fed forward, or only large motions show it"
    return left


def _changes_nothing(rig: Rig, name: str, plant: Linear) -> bool:
    """Whether a rig without an effect has the same matrices."""
    less = linearised(replace(rig, effects={other: given for other, given in rig.effects.items() if other != name}))
    return all(np.array_equal(a, b) for a, b in zip(less, plant, strict=True))


def _without_dry_friction(rig: Rig) -> Rig:
    """A rig without what holds its bodies at rest; viscous friction stays."""
    kept = {name: given for name, given in rig.effects.items() if not issubclass(BY_NAME[name], Dry)}
    numbers = {name: value for name, value in rig.numbers.items() if name not in DRY}
    return replace(rig, numbers=numbers, effects=kept, free=(), per_run=(), tied={})


def describing_function(rig: Rig, amplitudes: Float[np.ndarray, " a"]) -> Float[np.ndarray, " a"]:
    """Slope of the axis's dry friction for an oscillation, the mean of both directions.

    Args:
        rig: A rig with one axis.
        amplitudes: Amplitudes of its rate [rad/s], `(a,)`.

    Returns:
        Slope at each of them [N m s/rad], `(a,)`; 0 for a rig without dry friction.
    """
    structure = structure_of(rig)
    plant = one_axis_plant_of(structure, jnp.asarray(theta_of(rig, structure)))
    at = structure.states.index("w")
    dry = [effects for body, effects in plant.bodies() if body.rate == at]
    if not dry:
        return np.zeros(len(amplitudes))

    def level(w: Float[jax.Array, ""]) -> Float[jax.Array, ""]:
        zero, rest = jnp.zeros(()), jnp.zeros(len(structure.states))
        ways = ((plant.motion(zero, tuple(rest.at[at].set(way * w)), zero), way) for way in (1.0, -1.0))
        return 0.5 * sum((friction_level(dry[0], motion, way) for motion, way in ways), start=zero)

    theta = np.pi * (np.arange(ANGLES) + 0.5) / ANGLES
    levels = np.asarray(jax.jit(jax.vmap(level))(jnp.asarray(np.outer(amplitudes, np.sin(theta)).ravel())))
    return 2.0 / amplitudes * np.mean(levels.reshape(len(amplitudes), ANGLES) * np.sin(theta), axis=1)
