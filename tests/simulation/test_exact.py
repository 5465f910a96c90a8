"""The exact solver: resting bodies do not move, windows join, late readings; what it has and has not to choose."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT, Exact
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.simulation.simulate import simulate
from rwjax.simulation.windows import plant_of_run
from tests.systems import platform, record

T = np.arange(101) * 0.01


def test_a_body_rests_exactly_up_to_its_breakaway_level_and_slides_beyond() -> None:
    level = 0.05 / 0.4  # V
    found = simulate(platform(), T, np.where(T < 0.5, 0.999 * level, 1.01 * level))["yaw_rad_s"]
    assert not found[T <= 0.5].any() and np.all(np.diff(found[T >= 0.5]) > 0.0)


@pytest.mark.slow
def test_windows_from_the_nodes_of_a_whole_run_and_its_first_windows_are_that_run() -> None:
    structure = structure_of(platform())
    batch = pose(structure, (record(T, np.sin(9.0 * T)),), {"yaw_rad": 1.0}).batch
    theta, start = jnp.asarray(theta_of(platform(), structure)), jnp.asarray([[0.0, 0.3]])

    def all_three(run: Batch, x0: Array) -> list:
        plant = plant_of_run(structure, theta, run)
        whole, nodes = EXACT.whole(plant, run, x0)
        return [whole, nodes, *EXACT.beginning(plant, run, x0, jnp.asarray(2)), *EXACT.windows(plant, run, nodes)]

    found = jax.jit(lambda batch: EXACT.of_logs(all_three, batch, start))(batch)
    whole, nodes, first, begun, each, ends = (np.asarray(a)[0] for a in found)
    assert batch.windows > 2 and nodes[0] == pytest.approx(start[0])
    assert first[:2] == pytest.approx(whole[:2], rel=1e-13) and not first[2:].any()
    assert begun[:2] == pytest.approx(nodes[:2], rel=1e-13) and not begun[2:].any()
    assert each == pytest.approx(whole, rel=1e-12, abs=1e-15) and ends[:-1] == pytest.approx(nodes[1:], rel=1e-12)


def test_it_has_nothing_to_choose_and_nothing_to_say() -> None:
    assert EXACT.suited(platform(), [record(T, T)]) is EXACT and EXACT.by_commands() is EXACT
    assert EXACT.sign_width is None and EXACT.notes(platform(), []) == [] and not EXACT.smooth and EXACT.from_library


class OwnStep(type(EXPONENTIAL_STEP)):
    """A stepper of somebody else."""

    from_library = False


def test_programs_with_a_stepper_of_others_are_not_the_librarys() -> None:
    assert not Exact(OwnStep()).from_library
