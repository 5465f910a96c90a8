"""Jaxprs as flat lists of equations."""

import jax
import jax.numpy as jnp
import numpy as np

from rwjax.lowering.arrays import Spread
from rwjax.lowering.flow import ABSENT, carried_spreads, flattened, invariant, result_spreads

SAME, OF_LANE = Spread(), Spread(lanes=True)


def test_calls_are_written_out_and_repeats_worked_out_once() -> None:
    once = jax.jit(lambda x: jnp.sin(x) + 1.0)
    program = flattened(jax.make_jaxpr(lambda x: once(x) * once(x))(1.0))
    assert [q.name for q in program.equations] == ["sin", "add", "mul"]
    assert program.equations[-1].inputs[0] is program.equations[-1].inputs[1]


def test_numbers_that_differ_are_no_repeats() -> None:
    program = flattened(jax.make_jaxpr(lambda x: (x + 1.0) * (x + 2.0) * (x + 1.0))(0.5))
    assert sum(q.name == "add" for q in program.equations) == 2


def test_what_nothing_needs_is_left_out() -> None:
    program = flattened(jax.make_jaxpr(lambda x: (jnp.exp(x), jnp.cos(x))[1])(1.0))
    assert [q.name for q in program.equations] == ["cos"]


def test_what_does_not_depend_on_a_variable_stands_before_it() -> None:
    program = flattened(jax.make_jaxpr(lambda a, b: jnp.sin(a) * b)(1.0, 2.0))
    still, moving = invariant(program, program.inputs[1:])
    assert [q.name for q in still] == ["sin"] and [q.name for q in moving] == ["mul"]


def test_results_differ_over_what_their_arguments_do() -> None:
    program = flattened(jax.make_jaxpr(lambda a, b: (a * 2.0, a + b))(1.0, 2.0))
    assert result_spreads(program, [SAME, OF_LANE]) == [SAME, OF_LANE]


def test_what_a_loop_hands_on_differs_as_soon_as_any_turn_makes_it() -> None:
    def turn(carry, x):
        a, b, c = carry
        return (b, c, x), a

    body = jax.make_jaxpr(lambda xs: jax.lax.scan(turn, (0.0, 0.0, 0.0), xs))(np.zeros(4)).eqns[0].params["jaxpr"]
    assert carried_spreads(flattened(body), [], [SAME] * 3, [OF_LANE]) == [OF_LANE] * 3
    assert carried_spreads(flattened(body), [], [SAME] * 3, [SAME]) == [SAME] * 3


def test_what_nothing_in_a_loop_asks_for_is_not_worked_out() -> None:
    def function(x: jax.Array) -> jax.Array:
        unused, used = jnp.cumsum(x), jnp.sin(x)
        rows = jax.lax.scan(lambda c, row: (c + row[1], None), 0.0, (unused, used))[0]
        until = jax.lax.while_loop(lambda c: c[0] < 3.0, lambda c: (c[0] + used[0] ** 2 + 1.0, c[1] * 1.0), (0.0, x[0]))
        return rows + until[0]

    program = flattened(jax.make_jaxpr(function)(jnp.ones(30)))
    assert "cumsum" not in [q.name for q in program.equations]
    assert "sin" in [q.name for q in program.equations]
    assert [v is ABSENT for q in program.equations if q.name == "scan" for v in q.inputs] == [False, True, False]
