"""Rigs with two axes and their motion, for tests."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from rwjax import parse_rig
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP

GIMBAL = """
[gimbal]
difference = -0.012
product_xy = 0.002
product_xz = 0.003
product_yz = -0.0015
"""
TILTING = """
[effects."wheel_1.gyroscopic"]
s = 1.0
"""
GRAVITY = """
[pitch.gravity]
torque = 0.15
angle = 0.3
"""


def two_axis(more: str = "", *, ohm: float = 0.83, J: float = 1.24e-4) -> Rig:
    """A testbed with a wheel of `J` [kg m2] on each axis, and motors of `ohm`; `more`: further sections."""
    motors = "".join(
        f"[motor_{k}]\ntorque_constant = 0.0182\nresistance = {ohm!r}\n[wheel_{k}]\ninertia = {J!r}\n" for k in (1, 2)
    )
    return parse_rig(f'kind = "two_axis"\n[yaw]\ninertia = 0.0495\n[pitch]\ninertia = 0.021\n{motors}{more}')


@partial(jax.jit, static_argnums=0)
def _run(structure: Structure, theta, x, u, every, h):
    plant = plant_of(structure, theta)
    p = EXPONENTIAL_STEP.prepare(plant, h)

    def several(x, u):
        return jax.lax.fori_loop(0, every, lambda _, x: EXPONENTIAL_STEP.step(plant, p, jnp.zeros(()), x, u, h), x), x

    end, states = jax.lax.scan(several, tuple(x), u)
    return jnp.concatenate([jnp.stack(states, axis=-1), jnp.stack(end)[None]])


def motion(rig: Rig, start: dict[str, float], u: np.ndarray, h: float, every: int = 1) -> dict[str, np.ndarray]:
    """States `(n + 1,)` by name, `every` steps of `h` [s] for each of the commands `u` (n, 2)."""
    structure = structure_of(rig)
    x = jnp.asarray([start.get(name, 0.0) for name in structure.states])
    theta = jnp.asarray(theta_of(rig, structure))
    found = _run(structure, theta, x, jnp.asarray(u), jnp.asarray(every), jnp.asarray(h))
    return dict(zip(structure.states, np.asarray(found).T, strict=True))
