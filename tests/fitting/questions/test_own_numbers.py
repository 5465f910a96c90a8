"""A rig file's own numbers as a fit that has not moved."""

from dataclasses import replace

import numpy as np

from rwjax.fitting.questions.own_numbers import at_own_numbers
from tests.fitting.questions.test_numbers import RIG, U, log


def test_it_has_the_files_numbers_and_their_cost() -> None:
    here = at_own_numbers(RIG, [log(U)])
    assert here is not None and here.free == RIG.free
    assert {name: here.numbers()[name] for name in RIG.values if name in here.numbers()} == {
        name: value for name, value in RIG.values.items() if name in here.numbers()
    }
    off = at_own_numbers(RIG.with_values({"axis.inertia": 0.2}), [log(U)])
    assert off is not None and off.cost > 100.0 * here.cost


def test_there_is_none_where_nothing_is_free_read_or_finite() -> None:
    read = log(U)
    nothing = replace(read, outputs={"yaw_rad": np.full(len(read.time), np.nan)})
    assert at_own_numbers(replace(RIG, free=()), [read]) is None and at_own_numbers(RIG, [nothing]) is None
    other = replace(
        read, outputs={"current_A": read.outputs["yaw_rad"]}, resolution={"current_A": 0.0}
    )  # a platform has none
    assert at_own_numbers(RIG, [other]) is None
