"""Stable gains: against the roots of the same polynomials, and the share of many plants."""

import numpy as np
import pytest

from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import pd_loop
from rwjax.control.region import region
from rwjax.control.stability import share_of_plants, stable
from rwjax.control.transfer import Transfer, transfer
from rwjax.plant.from_rig import structure_of, theta_of
from tests.control.thesis_axis import GRID, SLOPE, THESIS, I, J, K, L, R, b


@pytest.mark.parametrize("damping", [0.2, 0.4])
def test_damped_pairs_are_those_whose_roots_are_damped(damping: float) -> None:
    loop = pd_loop(transfer(linearised(THESIS)))
    found = stable(loop, GRID[::7, None], GRID[None, ::7], sigma=0.5, damping=damping)
    for i, kp in enumerate(GRID[::7]):
        for j, kd in enumerate(GRID[::7]):
            poles = loop.poles(kp, kd)
            assert found[i, j] == bool(np.all(poles.real < -0.5) and np.all(-poles.real > damping * np.abs(poles)))
    assert 5 < found.sum() < found.size - 50


def test_the_polynomial_as_the_thesis_prints_it() -> None:
    # R b2/(I L) stands in the coefficient of s^2; it belongs to s
    motor = (R * b + K**2) / (J * L)
    den = np.array([1.0, R / L + b / J + SLOPE + SLOPE * R / L, motor + SLOPE * b / J, SLOPE * motor])
    printed = Transfer(np.array([K / (L * I)]), den, ())
    assert stable(pd_loop(printed), GRID[:, None], GRID[None, :], sigma=0.5).sum() == 6928


def test_the_share_of_plants_is_what_each_of_them_says() -> None:
    rng = np.random.default_rng(5)
    structure = structure_of(THESIS)
    thetas = theta_of(THESIS, structure) * np.exp(rng.normal(0.0, 0.2, (40, len(structure.names))))
    plants = transfer(linearised(THESIS, thetas=thetas))
    kp, kd = GRID[::4], GRID[::7]
    one_by_one = []
    for num, den in zip(plants.num, plants.den, strict=True):
        one_by_one.append(stable(pd_loop(Transfer(num, den, ())), kp[:, None], kd[None, :], sigma=0.5))
    assert np.array_equal(share_of_plants(plants, kp, kd, 0.5), np.mean(one_by_one, axis=0))
    single = transfer(linearised(THESIS.with_values(dict(zip(structure.names, thetas[7], strict=True)))))
    assert plants.den[7] == pytest.approx(single.den, rel=1e-9) and plants.num[7] == pytest.approx(single.num, rel=1e-9)


def test_many_gains_in_blocks_are_those_of_one_block() -> None:
    plants = transfer(linearised(THESIS, thetas=theta_of(THESIS, structure_of(THESIS))[None]))
    wide = np.linspace(0.0, 100.0, 151)
    found = share_of_plants(plants, wide, wide, 0.5)
    assert np.array_equal(found, region(THESIS, wide, wide, 0.5).stable)
