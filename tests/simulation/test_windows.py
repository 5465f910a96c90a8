"""Logs worked out together, and a plant moved through one window."""

import jax.numpy as jnp
import numpy as np

from rwjax.fitting.problem import pose
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.simulation.windows import log_by_log, plant_of_run, prepare, side_by_side, time_grid
from tests.systems import platform, record

T = np.arange(41) * 0.01
LOGS = [record(T, np.full_like(T, 0.1)), record(2.0 * T, np.full_like(T, 0.2))]


def test_logs_side_by_side_are_logs_one_by_one() -> None:
    structure = structure_of(platform())
    batch = pose(structure, LOGS, {"yaw_rad": 1.0}).batch
    scale = jnp.array([2.0, 3.0])

    def one(run, factor):
        return factor * run.h, run.u_command[0] * len(run.step_index)

    together, apart = side_by_side(one, batch, scale), log_by_log(one, batch, scale)
    for a, b in zip(together, apart, strict=True):
        assert np.array_equal(a, b)
    assert np.array_equal(together[0], scale * batch.h)
    assert np.allclose(together[1], np.array([0.1, 0.2]) * len(batch.step_index))


def test_a_log_has_its_own_numbers_and_the_loggers_clock_stretches_its_grid() -> None:
    structure = structure_of(platform()).with_effects("sensor.clock")
    batch = pose(structure, LOGS, {"yaw_rad": 1.0}, per_run=("axis.inertia",)).batch
    theta = np.append(theta_of(platform(), structure), [0.3, 0.4])
    theta[[name.startswith("sensor.clock") for name in structure.names] + [False] * 2] = 0.01

    def one(run):
        plant = plant_of_run(structure, jnp.asarray(theta), run)
        return plant.numbers["axis.inertia"], time_grid(plant, run)[0] / run.h / plant.pace(), plant.pace()

    inertia, ratio, pace = side_by_side(one, batch)
    assert np.allclose(inertia, [0.3, 0.4]) and np.allclose(ratio, 1.0) and np.all(pace != 1.0)


def test_a_window_holds_the_states_of_all_its_steps() -> None:
    structure = structure_of(platform("viscous = 0.0"))
    plant = plant_of(structure, jnp.asarray(theta_of(platform("viscous = 0.0"), structure)))
    moved = prepare(plant, EXPONENTIAL_STEP, jnp.asarray(0.1))
    psi, w = moved.states(jnp.zeros(()), jnp.array([0.5, 1.0]), jnp.array([1.0, 1.0, -1.0]))
    t, a = np.array([0.0, 0.1, 0.2]), 0.4 / 0.1  # rad/s2
    assert np.allclose(w, [*(1.0 + a * t), 1.0 + a * 0.1], rtol=1e-12)
    assert np.allclose(psi[:3], 0.5 + t + 0.5 * a * t**2, rtol=1e-12)
