"""The search by optimistix: where it may go, and that side by side it is the same as alone."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.fitting.optimise import FURTHEST, Unknowns, optimise
from rwjax.fitting.problem import Problem, pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.simulate import simulate
from rwjax.simulation.smooth import Smooth
from tests.systems import platform, record

T = np.arange(201) * 0.01
U = 0.5 * np.sin(3.0 * T)
RIG = platform()
SOLVER = Smooth(0.01).suited(RIG, [record(T, U)])
NAMES = structure_of(RIG).names


def problem() -> Problem:
    """One run without noise."""
    return pose(
        structure_of(RIG),
        [record(T, U, dict(simulate(RIG, T, U, solver=SOLVER)))],
        {"yaw_rad": 1e-4, "yaw_rad_s": 1e-3},
    )


def unknowns(theta: np.ndarray, least: float = 0.0) -> Unknowns:
    """Inertia, in its logarithm, and Coulomb friction, at least `least`."""
    index = np.array([NAMES.index("axis.inertia"), NAMES.index("axis.friction.coulomb")])
    return Unknowns(
        theta=theta,
        start=np.zeros((1, 2)),
        index=index,
        logarithmic=np.array([True, False]),
        size=np.array([1.0, 0.05]),
        bounds=np.array([[1e-12, np.inf], [least, np.inf]]),
        start_index=np.zeros((0, 2), int),
        response=np.zeros((1, 2, 2)),
        scale=np.array([1e-2, 1e-2]),
    )


def searched(*starts: Unknowns):
    p = problem()
    count = len(starts)
    every = Unknowns(*map(np.stack, zip(*starts, strict=True)))
    weight, prior = np.stack([p.batch.weight] * count), np.zeros((count, len(NAMES), 2))
    return optimise(p.structure, every, weight, prior, np.array(1e-6), p.batch, solver=SOLVER)


@pytest.mark.slow
def test_side_by_side_each_start_ends_where_the_numbers_are() -> None:
    theta = theta_of(RIG, structure_of(RIG))
    free = np.isin(NAMES, ("axis.inertia", "axis.friction.coulomb"))
    found = searched(unknowns(np.where(free, 1.2 * theta, theta)), unknowns(np.where(free, 0.9 * theta, theta)))
    for s in range(2):
        assert found.theta[s] == pytest.approx(theta, rel=1e-4) and found.cost[s] < 1e-3
        assert np.array_equal(found.theta[s][~free], theta[~free])  # what is not free stays


@pytest.mark.slow
def test_bounds_hold_and_a_logarithm_goes_no_further_than_it_may() -> None:
    theta = theta_of(RIG, structure_of(RIG))
    begin = unknowns(np.where(np.array(NAMES) == "axis.friction.coulomb", 0.09, theta), least=0.08)
    found = searched(begin, begin)
    assert found.theta[0, NAMES.index("axis.friction.coulomb")] == pytest.approx(0.08, rel=1e-9)
    far, _ = unknowns(theta).at(jnp.array([1e9, -1e9]))
    assert far[NAMES.index("axis.inertia")] == pytest.approx(0.1 * np.exp(FURTHEST), rel=1e-12)
    assert far[NAMES.index("axis.friction.coulomb")] == 0.0


def test_initial_states_follow_the_numbers_along_a_line() -> None:
    theta = theta_of(RIG, structure_of(RIG))
    along = unknowns(theta)._replace(
        response=np.array([[[0.0, 2.0], [0.0, 0.0]]]), start_index=np.array([[0, 1]]), scale=np.full(3, 0.1)
    )
    moved, start = along.at(jnp.array([0.0, 1.0, 3.0]))
    assert moved[NAMES.index("axis.friction.coulomb")] == pytest.approx(0.055)
    assert np.asarray(start) == pytest.approx(np.array([[2.0 * 0.005, 0.3]]))
