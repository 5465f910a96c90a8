"""Loop polynomials: affine in the gains, with poles where the roots of the written-out polynomial lie."""

import numpy as np
import pytest

from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import loop_of_rows, pd_loop, pid_loop, times_variable
from rwjax.control.stability import stable
from rwjax.control.transfer import Transfer, transfer
from tests.control.thesis_axis import THESIS


def test_an_integral_part_moves_every_pole() -> None:
    plant = transfer(linearised(THESIS))
    loop, rng = pid_loop(plant), np.random.default_rng(3)
    gains = rng.uniform(0.0, (60.0, 200.0, 20.0), (200, 3))
    by_roots = [np.all(loop.poles(*g).real < 0.0) for g in gains]
    assert np.array_equal(stable(loop, *gains.T), by_roots) and 10 < sum(by_roots) < 190


def test_a_loop_s_coefficients_are_those_of_the_written_out_polynomial() -> None:
    plant = Transfer(np.array([-3.0]), np.array([1.0, 2.0, 5.0]), ())  # a command turns it backwards
    pd, pid = pd_loop(plant), pid_loop(plant)
    assert np.array_equal(pd.base + np.array([7.0, 4.0]) @ pd.gains, [1.0, 2.0 + 3.0 * 4.0, 5.0 + 3.0 * 7.0])
    coefficients = [1.0, 2.0 + 3.0 * 4.0, 5.0 + 3.0 * 7.0, 3.0 * 6.0]
    assert np.array_equal(pid.base + np.array([7.0, 6.0, 4.0]) @ pid.gains, coefficients)
    assert (pd.order, pid.order) == (2, 3)
    doubled = pd.mapped(2.0 * np.eye(3))
    assert doubled.poles(7.0, 4.0) == pytest.approx(pd.poles(7.0, 4.0))


def test_rows_of_any_order_stand_under_each_other() -> None:
    found = loop_of_rows(np.array([1.0, 2.0]), [np.array([3.0]), times_variable(np.array([4.0, 5.0]), 2)])
    assert found.base.tolist() == [0.0, 0.0, 1.0, 2.0]
    assert found.gains.tolist() == [[0.0, 0.0, 0.0, 3.0], [4.0, 5.0, 0.0, 0.0]]
