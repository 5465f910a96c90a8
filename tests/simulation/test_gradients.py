"""Derivatives of a simulated run against central differences: every kind of rig, both solvers, forward and reverse mode."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.exact import EXACT
from rwjax.simulation.simulate import simulate
from rwjax.simulation.smooth import Smooth
from rwjax.simulation.solver import Solver
from tests.systems import MOTOR

TIMES = """
[effects."{drive}.delay"]
tau = 0.0137
[effects."sensor.delay"]
tau = 0.0071
[effects."sensor.clock"]
e = 0.01
"""
ON_WHEEL = '[effects."wheel.coulomb"]\nM_c = 2e-4\n'
STRIBECK = "[axis.friction]\nviscous = 0.02\ncoulomb = 0.05\nstatic = 0.06\nstribeck_velocity = 0.05\n"
MOTORS = "".join(
    f"[motor_{k}]\ntorque_constant = 0.0182\nresistance = 0.83\nfriction = 4e-6\n[wheel_{k}]\ninertia = 1.24e-4\n"
    for k in (1, 2)
)
GIMBAL = "[gimbal]\ndifference = -0.012\nproduct_xy = 0.002\nproduct_xz = 0.003\nproduct_yz = -0.0015\n"
BODIES = """
[yaw]
inertia = 0.0495
[yaw.friction]
coulomb = 0.004
[pitch]
inertia = 0.021
[pitch.friction]
coulomb = 0.003
[pitch.gravity]
torque = 0.05
angle = 0.3
"""
RIGS = {
    "platform": f'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n{STRIBECK}{TIMES.format(drive="drive")}',
    "wheel": f'kind = "wheel"\n{MOTOR}{ON_WHEEL}{TIMES.format(drive="drive")}',
    "reaction": f'kind = "reaction"\n{MOTOR}[axis]\ninertia = 0.0495\n{STRIBECK}{ON_WHEEL}{TIMES.format(drive="drive")}',
    "two_axis": f'kind = "two_axis"\n{MOTORS}{BODIES}{GIMBAL}{TIMES.format(drive="drive_2")}',
}
SOLVERS = {"exact": EXACT, "smooth": Smooth(0.02, rtol=1e-10, atol=1e-12)}
T, CHANGED = np.arange(16) * 0.02, 5
STEP = 1e-5
"""Change of each value for the difference, in units of its own size [1]."""


FAST = ("exact", "platform")


@pytest.mark.parametrize(
    ("solver", "kind"),
    [
        pytest.param(solver, kind, marks=() if (solver, kind) == FAST else pytest.mark.slow)
        for solver in SOLVERS
        for kind in RIGS
    ],
)
@pytest.mark.slow
def test_derivatives_by_numbers_first_state_and_command_are_those_of_differences(solver: str, kind: str) -> None:
    rig = parse_rig(RIGS[kind])
    names, run = in_one_vector(rig, SOLVERS[solver])
    here, steps = jnp.zeros(len(names)), STEP * np.eye(len(names))
    forward = np.asarray(jax.jacfwd(run)(here))
    every = np.asarray(jax.jit(jax.vmap(run))(np.concatenate([steps, -steps])))
    differences = np.moveaxis((every[: len(names)] - every[len(names) :]) / (2.0 * STEP), 0, -1)
    largest = np.max(np.abs(differences), axis=(0, 2))
    for k, name in enumerate(names):
        assert np.any(differences[..., k]), name
        error = np.max(np.abs(forward[..., k] - differences[..., k]), axis=0) / largest
        assert np.all(error < 1e-5), (name, error)
    weights = np.random.default_rng(3).normal(size=forward.shape[:2]) / largest
    reverse = jax.grad(lambda z: jnp.sum(weights * run(z)))(here)
    expected = np.einsum("ty,typ->p", weights, forward)
    np.testing.assert_allclose(reverse, expected, rtol=1e-9, atol=1e-9 * np.max(np.abs(expected)))


def in_one_vector(rig: Rig, solver: Solver) -> tuple:
    """Names of all that a run depends on, and the run as a function of their changes, each in units of its size."""
    structure = structure_of(rig)
    own = {n: v for n, v in zip(structure.names, theta_of(rig, structure), strict=True) if v != 0.0}
    rng = np.random.default_rng(3)
    start = {state: 0.05 * rng.normal() for state in structure.states}
    u = (1.0 if rig.kind == "platform" else 4.0) * np.sin(10.0 * np.pi * T + 0.3)
    u = np.stack([u, -0.7 * u], axis=1) if rig.kind == "two_axis" else u
    at = (CHANGED, 0) if u.ndim == 2 else CHANGED
    values = np.array([*own.values(), *start.values(), u[at]])
    size = np.where(np.arange(len(values)) < len(own), np.abs(values), 1.0)

    def run(change: jax.Array) -> jax.Array:
        z = values + size * change
        numbers = dict(zip(own, z, strict=False))
        first = dict(zip(start, z[len(own) :], strict=False))
        found = simulate(rig, T, jnp.asarray(u).at[at].set(z[-1]), numbers=numbers, start=first, solver=solver)
        return jnp.stack([*found.values()], axis=1)

    return (*own, *start, "command"), run
