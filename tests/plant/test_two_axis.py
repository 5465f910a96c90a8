"""The plant with two axes against laws of conservation, Lagrange's equations, one axis alone, and MuJoCo."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax import parse_rig
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from tests.two_axes import GIMBAL, GRAVITY, TILTING, motion, two_axis
from tests.two_axis_drift import Q_NAMES, W_NAMES, drift, energy, lagrangian

WHOLE = two_axis(GIMBAL + GRAVITY + TILTING)


@jax.jit
def accelerations(q, qd, u):
    """By Lagrange's equations, and the library's."""

    def L(q, qd):
        return lagrangian(WHOLE.values, q, qd)

    force = jnp.concatenate([jnp.zeros(2), 0.0182 * (u - 0.0182 * qd[2:]) / 0.83])
    right = force + jax.grad(L, 0)(q, qd) - jax.jacfwd(jax.grad(L, 1), 0)(q, qd) @ qd
    structure = structure_of(WHOLE)
    state = dict(zip((*Q_NAMES, *W_NAMES), (*q, *qd), strict=True))
    plant = plant_of(structure, jnp.asarray(theta_of(WHOLE, structure)))
    rates = plant.field(jnp.zeros(()), tuple(state[name] for name in structure.states), u)
    found = dict(zip(structure.states, rates, strict=True))
    return jnp.linalg.solve(jax.hessian(L, 1)(q, qd), right), jnp.stack([found[n] for n in W_NAMES])


EIGHT = st.lists(st.floats(-1.5, 1.5), min_size=8, max_size=8)


@given(x=EIGHT, u=st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=2))
def test_the_accelerations_are_those_of_lagranges_equations(x: list[float], u: list[float]) -> None:
    expected, found = accelerations(np.array(x[:4]), np.array(x[4:]) * [1.0, 1.0, 200.0, 200.0], np.array(u))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_energy_and_momentum_are_kept_to_the_steps_second_order() -> None:
    found = np.array([drift(step) for step in (0.02, 0.01, 0.005)])
    assert np.all(found[-1] < 1e-4), found  # at 5 ms
    assert np.all(np.log2(found[-2] / found[-1]) > 1.8), found


@pytest.mark.slow
def test_a_motor_changes_no_momentum_about_the_vertical() -> None:
    u = 6.0 * np.stack([np.sign(np.sin(0.05 * np.arange(800))), np.cos(0.03 * np.arange(800))], axis=1)
    drift = []
    for k in (1, 2):
        found = motion(two_axis(GIMBAL + GRAVITY + TILTING), {"psi_2": 0.2}, u, 0.01 / k, k)
        drift.append(np.max(np.abs(energy(WHOLE, found)[1])))
        assert np.ptp(found["Omega_1"]) > 300.0 and np.ptp(found["psi_2"]) > 1.0
    assert (
        drift[1] < 0.3 * drift[0] < 0.3 * 1e-3 * 1.24e-4 * 300.0
    )  # second order, a thousandth of what the wheel takes up


LOCKED = "[{}.friction]\ncoulomb = 1e3\n"
SQUARE = 6.0 * np.sign(np.sin(0.05 * np.arange(600)))


def on_one_axis(J: float, I: float) -> dict[str, np.ndarray]:
    motor = "[motor]\ntorque_constant = 0.0182\nresistance = 0.83\n"
    rig = parse_rig(f'kind = "reaction"\n{motor}[wheel]\ninertia = {J!r}\n[axis]\ninertia = {I!r}\n')
    return motion(rig, {"Omega": 40.0}, SQUARE, 0.01)


@pytest.mark.parametrize("half, I", [pytest.param(1, 0.0495, marks=pytest.mark.slow), (2, 0.021)])
def test_one_axis_with_the_other_locked_is_a_reaction_rig_of_the_reduced_inertia(half: int, I: float) -> None:
    J, u = 1e-3, np.zeros((600, 2))
    u[:, half - 1] = SQUARE
    both = motion(two_axis(LOCKED.format("pitch" if half == 1 else "yaw"), J=J), {f"Omega_{half}": 40.0}, u, 0.01)
    # J (Omega' + w') = tau and I w' = -tau make Omega' = tau (1/J + 1/I)
    reduced, alone = on_one_axis(J * I / (I + J), I), on_one_axis(J, I)
    for name, exact in reduced.items():
        scale = np.max(np.abs(exact))
        np.testing.assert_allclose(both[f"{name}_{half}"], exact, rtol=0.0, atol=1e-9 * scale)
        assert 0.1 * J / I < np.max(np.abs(alone[name] - exact)) / scale < J / I  # what a `reaction` rig drops
    assert not both[f"w_{3 - half}"].any() and not both[f"psi_{3 - half}"].any()


DRY = "[yaw.friction]\ncoulomb = {}\n[pitch.friction]\ncoulomb = {}\n"
DRY += '[effects."wheel_1.coulomb"]\nM_c = {}\n[effects."wheel_2.coulomb"]\nM_c = {}\n'


@pytest.mark.slow
def test_bodies_that_push_one_another_stick_exactly() -> None:
    """A torque within every level moves nothing; beyond yaw's, the other bodies stay where they are."""
    rig = two_axis(GIMBAL + GRAVITY + TILTING + DRY.format(0.02, 0.2, 0.03, 0.05))
    start = {"psi_2": 0.2, "psi_1": 0.1}
    still = motion(rig, start, np.tile([0.8, 1.5], (200, 1)), 0.005)
    for name, value in still.items():
        assert np.ptp(value) == 0.0, name
    u = np.tile([4.0, -1.5], (600, 1)) * (np.arange(600) // 30 % 5 == 0)[:, None]  # pushes with pauses
    found = motion(rig, start, u, 0.005)
    assert np.ptp(found["psi_1"]) > 0.01 and np.ptp(found["theta_1"]) > 1.0
    assert np.any(found["w_1"][50:] == 0.0) and np.any(found["w_1"] != 0.0)
    assert np.ptp(found["psi_2"]) == 0.0 and np.ptp(found["theta_2"]) == 0.0


@pytest.mark.slow
def test_dry_friction_on_all_bodies_at_once_is_of_second_order() -> None:
    rig = two_axis(GIMBAL + GRAVITY.replace("0.15", "0.03") + TILTING + DRY.format(0.006, 0.004, 0.003, 0.003), J=1e-3)
    t = 0.04 * np.arange(100)
    u = np.stack([5.0 * np.sin(1.7 * t), 4.0 * np.cos(2.3 * t)], axis=1)
    *coarse, exact = (np.stack([*motion(rig, {"psi_2": 0.3}, u, 0.04 / k, k).values()]) for k in (8, 16, 32, 256))
    assert np.sum(np.diff(np.sign(exact[[1, 3, 5, 7]]), axis=1) != 0) > 8  # bodies stop and turn
    error = [np.max(np.sqrt(np.mean((x - exact) ** 2, axis=1)) / np.ptp(exact, axis=1)) for x in coarse]
    assert np.log2(error[0] / error[2]) / 2.0 > 1.7, error  # 1.85: crossings add a part of third order in the step


@pytest.mark.slow
def test_dry_friction_beside_a_body_that_is_held_is_of_second_order() -> None:
    """Wheel 1 turns while yaw is held: its inertia is then not the one beside a yaw that gives way."""
    rig = two_axis(LOCKED.format("yaw") + '[effects."wheel_1.coulomb"]\nM_c = 0.03\n', J=0.01)
    t = 0.04 * np.arange(200)
    u = np.stack([6.0 * np.sin(3.4 * t), 0.0 * t], axis=1)
    *coarse, exact = (motion(rig, {}, u, 0.04 / k, k)["Omega_1"] for k in (8, 16, 32, 64, 1024))
    assert np.sum(np.diff(np.sign(exact)) != 0) > 8  # stops and turns
    error = [np.max(np.abs(Omega - exact)) for Omega in coarse]
    assert np.log2(error[0] / error[-1]) / 3.0 > 1.7, error


@pytest.mark.slow
def test_smooth_friction_is_that_of_sliding_bodies_and_within_the_wheels_changes_no_momentum() -> None:
    on_axes = "[yaw.friction]\ncoulomb = 0.004\n[pitch.friction]\ncoulomb = 0.003\n"
    on_wheels = "".join(f'[effects."wheel_{k}.coulomb"]\nM_c = 2e-4\n' for k in (1, 2))
    x = tuple(jnp.asarray(v) for v in (0.1, -0.4, 2.0, 30.0, 0.3, 0.7, -1.0, -20.0))
    for friction in (on_axes + on_wheels, on_wheels):
        rig = two_axis(GIMBAL + TILTING + friction)
        structure = structure_of(rig)
        plant = plant_of(structure, jnp.asarray(theta_of(rig, structure)))
        t, u = jnp.zeros(()), jnp.asarray([3.0, -2.0])
        smooth = plant.with_smooth_friction(t, x, u, jnp.asarray(1e-3))
        np.testing.assert_allclose(smooth, plant.with_friction(t, x, u, x).rates, rtol=1e-9, atol=1e-12)
    free = plant.field(t, x, u)
    change = dict(zip(structure.states, (a - b for a, b in zip(smooth, free, strict=True)), strict=True))
    n, at = plant.numbers, plant.carried(x[structure.states.index("psi_2")])
    H = n["wheel_1.inertia"] * (change["Omega_1"] + at.c * change["w_1"])
    vertical = at.A * change["w_1"] + at.P * change["w_2"] + at.c * H
    H_2 = n["wheel_2.inertia"] * (change["Omega_2"] + change["w_2"])
    assert abs(float(vertical)) < 1e-15 and float(H) == pytest.approx(-2e-4) and float(H_2) == pytest.approx(2e-4)
