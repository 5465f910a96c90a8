"""What the smooth solver costs: the newcomer's script solves the library's problem, and the yardsticks know the truth."""

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.smooth import against_newcomer, newcomer, rigs


def test_the_newcomer_begins_where_the_library_does() -> None:
    for case, rig in (("demo", rigs.demo().rig), ("emps", rigs.with_four_terms())):
        names = against_newcomer.NAMES[case]
        assert {names[short]: value for short, value in newcomer.START[case].items()} == {
            name: rig.values[name] for name in rig.free
        }


def test_the_newcomer_reads_the_demo_as_the_library_does() -> None:
    log = rigs.demo().train[0]
    t, u, y = newcomer.load("demo", [str(rigs.ROOT / "data" / "demo" / log.name)])
    assert np.array_equal(t, log.time) and np.array_equal(u[0], log.command)
    assert np.allclose(y[0], log.outputs["yaw_rad"], rtol=1e-12)


@pytest.mark.slow  # the separate simulator is compiled
def test_the_exact_yardstick_leaves_less_than_a_count_of_the_true_numbers_alone() -> None:
    trial = rigs.demo()
    right = against_newcomer.known("demo", trial)
    count = 2.0 * np.pi / 2048
    assert against_newcomer.exactly("demo", right, trial) < count
    assert against_newcomer.exactly("demo", right | {"coulomb": 1.01 * right["coulomb"]}, trial) > 3.0 * count
