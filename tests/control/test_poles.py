"""The slowest pole: against polynomials written out, their roots and finite differences."""

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.control.linear import Linear, linearised
from rwjax.control.loop_polynomial import pd_loop, pid_loop
from rwjax.control.over_gains import over_gains
from rwjax.control.poles import companion, largest_modulus, pd_matrix, pid_matrix, slowest_pole
from rwjax.control.sampled_loop import sampled_loop
from rwjax.control.stability import stable_sampled
from rwjax.control.transfer import Transfer, controller_form, transfer
from tests.control.thesis_axis import THESIS

TURNS = Linear(np.array([[0.0, 1.0], [-3.0, -0.2]]), np.array([0.0, 4.0]), np.array([1.0, 0.0]))
"""s² + 0.2 s + 3, a gain of 4."""


def test_pd_control_moves_the_poles_of_a_second_order_plant() -> None:
    (kp, kd), slowest = (5.0, 0.7), jax.jit(slowest_pole)
    assert float(slowest(np.array([kp, kd]), TURNS)) == pytest.approx(-(0.1 + 2.0 * kd))  # s² + (0.2 + 4 kd) s + …
    assert float(slowest(np.array([0.0, kd]), TURNS)) == pytest.approx(max(np.roots([1.0, 0.2 + 4.0 * kd, 3.0]).real))
    # a command that acts on the rate of what is read at once: 1 + 4 kd in front of s
    straight = Linear(np.array([[-3.0]]), np.array([4.0]), np.array([1.0]))
    expected = -(3.0 + 4.0 * kp) / (1.0 + 4.0 * kd)
    assert float(slowest(np.array([kp, kd]), straight)) == pytest.approx(expected)


def test_pid_control_has_the_poles_of_its_polynomial() -> None:
    gains, law = np.array([7.0, 3.0, 1.5]), jax.jit(pid_matrix)
    exact = np.roots([1.0, 0.2 + 4.0 * 1.5, 3.0 + 4.0 * 7.0, 4.0 * 3.0])
    assert np.sort_complex(np.linalg.eigvals(law(gains, TURNS))) == pytest.approx(np.sort_complex(exact))
    straight = Linear(np.array([[-3.0]]), np.array([4.0]), np.array([1.0]))  # (1 + 4 kd) s² + (3 + 4 kp) s + 4 ki
    found = np.linalg.eigvals(law(gains, straight))
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(np.roots([7.0, 31.0, 12.0])))


def test_any_linear_feedback_is_a_law() -> None:
    """Gains of the whole state, by Ackermann's formula: the poles come where they were put."""
    A, B = np.asarray(TURNS.A), np.asarray(TURNS.B)
    wanted = A @ A + 5.0 * A + 6.0 * np.eye(2)  # (s + 2)(s + 3)
    K = np.linalg.solve(np.column_stack([B, A @ B]).T, [0.0, 1.0]) @ wanted
    fed_back = partial(slowest_pole, law=lambda K, plant: plant.A - jnp.outer(plant.B, K))
    assert float(jax.jit(fed_back)(K, TURNS)) == pytest.approx(-2.0)


@pytest.mark.parametrize("make", [pd_loop, pid_loop])
def test_the_rig_s_own_loop_has_the_same_slowest_pole_by_matrix_and_polynomial(make: Callable) -> None:
    found = transfer(linearised(THESIS))
    loop, law = make(found), pd_matrix if make is pd_loop else pid_matrix
    gains = np.random.default_rng(2).uniform(0.0, 50.0, (5, len(loop.gains)))
    expected = [np.max(loop.poles(*g).real) for g in gains]
    by_matrix, by_polynomial = (partial(slowest_pole, law=law) for law in (law, companion))
    assert over_gains(by_matrix, gains, controller_form(found)) == pytest.approx(expected, rel=1e-8)
    assert over_gains(by_polynomial, gains, loop) == pytest.approx(expected, rel=1e-8)


def test_a_sampled_loop_is_stable_where_its_largest_modulus_is_below_1() -> None:
    loop = sampled_loop(transfer(linearised(THESIS)), 0.01, 0.013, 0.02)
    gains = np.random.default_rng(8).uniform(0.0, [600.0, 60.0], (100, 2))
    found = np.asarray(over_gains(largest_modulus, gains, loop))
    by_roots = [np.max(np.abs(1.0 + loop.poles(*g))) for g in gains]
    assert found == pytest.approx(by_roots, rel=1e-7)
    assert np.array_equal(found < 1.0, stable_sampled(loop, *gains.T)) and 10 < np.sum(found < 1.0) < 90


def test_its_gradient_is_that_of_finite_differences() -> None:
    plant, gains, step = controller_form(transfer(linearised(THESIS))), np.array([40.0, 10.0]), 1e-5
    by_gain, by_plant = jax.jit(jax.grad(slowest_pole, argnums=(0, 1)))(gains, plant)
    slowest = jax.jit(slowest_pole)
    for k in range(2):
        ahead, behind = (float(slowest(gains + s * step * np.eye(2)[k], plant)) for s in (1.0, -1.0))
        assert float(by_gain[k]) == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-6)
    ahead, behind = (float(slowest(gains, plant._replace(A=plant.A * (1.0 + s * step)))) for s in (1.0, -1.0))
    assert np.sum(by_plant.A * plant.A) == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-6)


def test_a_plant_that_turns_backwards_is_turned_forward() -> None:
    backwards = controller_form(Transfer(np.array([-2.0, -3.0]), np.array([1.0, 4.0, 5.0, 6.0]), (0.0,)))
    assert backwards.C.tolist() == [0.0, 2.0, 3.0]
    again = transfer(backwards)
    assert again.den == pytest.approx([1.0, 4.0, 5.0, 6.0]) and again.num == pytest.approx([2.0, 3.0])
