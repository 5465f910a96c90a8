"""Arrays of a program: few entries by themselves, many in memory."""

import jax.numpy as jnp
import numpy as np

from rwjax.lowering.arrays import Entries, Spread, all_indices
from tests.lowering.lowered import agrees


def test_spreads_join() -> None:
    assert Spread(lanes=True) | Spread(directions=True) == Spread(True, True)


def test_few_entries_stand_by_themselves_and_a_long_axis_does_not() -> None:
    assert Entries(np.empty((3, 4), object), "f").few
    assert not Entries(np.empty((40,), object), "f").few
    assert all_indices((2, 2)) == [(0, 0), (0, 1), (1, 0), (1, 1)]


def test_an_entry_of_few_may_be_chosen_when_the_program_runs() -> None:
    x = np.random.default_rng(5).normal(size=(9, 5))
    assert agrees(lambda x: (x * 2.0)[jnp.argmax(x)], x)


def test_what_is_looked_up_lies_in_memory() -> None:
    x = np.random.default_rng(6).normal(size=(9, 50))
    assert agrees(lambda x: jnp.sin(x)[jnp.argmax(x[:10]) + jnp.arange(20)], x)
