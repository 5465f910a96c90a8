"""Instructions on shared numbers and vectors."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from llvmlite import ir

from rwjax.lowering.emitter import Emitter, kind_of
from tests.lowering.lowered import agrees


def emitter() -> Emitter:
    function = ir.Function(ir.Module(), ir.FunctionType(ir.VoidType(), [ir.IntType(64)]), "f")
    return Emitter(ir.IRBuilder(function.append_basic_block()), 4)


@pytest.mark.parametrize(("dtype", "kind"), [(float, "f"), (int, "i"), (bool, "b"), (np.float32, "?"), (complex, "?")])
def test_kinds(dtype: type, kind: str) -> None:
    assert kind_of(np.dtype(dtype)) == kind


def test_numbers_of_python_are_worked_out_at_once() -> None:
    e = emitter()
    assert e.add(2, 3) == 5 and e.times(2, 3) == 6 and e.within(9, 4) == 4 and e.within(-1, 4) == 0
    assert not e.builder.block.instructions


@pytest.mark.parametrize("of", ["constant", "vector"])
def test_a_constant_is_made_once_and_told_from_others_that_are_equal(of: str) -> None:
    e = emitter()
    make = getattr(e, of)
    made = [make(value, kind) for value, kind in ((0.0, "f"), (-0.0, "f"), (1.0, "f"), (1, "i"), (True, "b"))]
    assert make(0.0, "f") is made[0] and make(-0.0, "f") is made[1]
    assert len({str(one) for one in made}) == 5


def test_a_term_is_emitted_once_in_a_block_and_again_behind_a_loop() -> None:
    e = emitter()
    argument = e.builder.function.args[0]
    first = e.once("key", lambda: e.add(argument, 1))
    with e.loop(3):
        assert e.once("key", lambda: e.add(argument, 1)) is first
        inner = e.once("inner", lambda: e.add(argument, 2))
    assert e.once("inner", lambda: e.add(argument, 2)) is not inner


def test_a_loop_over_entries_makes_no_product_of_a_division() -> None:
    e = emitter()
    number = e.builder.sitofp(e.builder.function.args[0], ir.DoubleType())
    with e.entries(5):
        assert e.inverse(number) is None
        with e.loop(3):
            inner = e.inverse(number)
    with e.loop(3):
        assert inner is not None and e.inverse(number) is not inner  # that one stands in a loop that has ended


def test_a_shared_number_meets_a_vector_in_every_lane() -> None:
    e = emitter()
    both = e.alike("ff", 1.5, e.vector(2.0, "f"))
    assert all(e.is_vector(term) for term in both)


def test_loops_hand_on_what_the_last_turn_leaves() -> None:
    x = np.random.default_rng(7).normal(size=(9, 3))
    assert agrees(lambda x: jax.lax.fori_loop(0, 4, lambda k, c: c * 0.5 + k.astype(float), x), x)
    assert agrees(lambda x: jax.lax.fori_loop(0, 0, lambda k, c: jnp.sin(c), x), x)
