"""Jaxprs worked out by numpy against JAX: every primitive that is there, and the linear part of every plant."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects.library import of_kind
from rwjax.lowering.by_numpy import RULES, worked_out
from rwjax.lowering.emitter import Unsupported
from rwjax.lowering.flow import flattened
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of
from rwjax.plant.structure import Structure
from rwjax.simulation.exponential_step import linear_part
from tests.joints import joint
from tests.systems import platform, reaction, wheel
from tests.two_axes import two_axis

RNG = np.random.default_rng(0)
X, Y, M = RNG.normal(size=4), RNG.normal(size=4), RNG.normal(size=(2, 3, 4))
EACH: dict[str, Callable] = {
    "sign": jnp.sign,
    "exp": jnp.exp,
    "log": lambda x: jnp.log(jnp.abs(x)),
    "log1p": lambda x: jnp.log1p(jnp.abs(x)),
    "expm1": jnp.expm1,
    "sin": jnp.sin,
    "cos": jnp.cos,
    "tan": jnp.tan,
    "tanh": jnp.tanh,
    "sqrt": lambda x: jnp.sqrt(jnp.abs(x)),
    "floor": jnp.floor,
    "ceil": jnp.ceil,
    "square": jax.lax.square,
    "add": lambda x: x + Y,
    "add_any": lambda x: jax.vjp(lambda a: a * a + jnp.sin(a), x)[1](jnp.ones(4))[0],
    "sub": lambda x: x - Y,
    "mul": lambda x: x * Y,
    "div": lambda x: x / Y,
    "pow": lambda x: jnp.abs(x) ** Y,
    "max": lambda x: jnp.maximum(x, Y),
    "min": lambda x: jnp.minimum(x, Y),
    "neg": lambda x: -x,
    "abs": jnp.abs,
    "eq": lambda x: x == X,
    "ne": lambda x: x != Y,
    "lt": lambda x: x < Y,
    "le": lambda x: x <= X,
    "gt": lambda x: x > Y,
    "ge": lambda x: x >= X,
    "integer_pow": lambda x: x**3,
    "select_n": lambda x: jnp.where(x > 0.0, x, Y),
    "convert_element_type": lambda x: (x > 0.0).astype(float),
    "copy": jnp.copy,
    "broadcast_in_dim": lambda x: jnp.broadcast_to(x[:, None], (4, 3)) + jax.lax.broadcast(x[:3], (4,)),
    "slice": lambda x: jnp.asarray(M)[:, 1:3, ::2] * x[0],
    "squeeze": lambda x: x[2],
    "reshape": lambda x: (jnp.asarray(M) * x[None, None]).reshape(4, 6),
    "iota": lambda x: jax.lax.broadcasted_iota(float, (2, 4), 1) * x[None],
    "split": lambda x: jax.lax.split(x, (1, 3)),
    "transpose": lambda x: (jnp.asarray(M) * x[None, None]).transpose(2, 0, 1),
    "concatenate": lambda x: jnp.concatenate([x, Y, x]),
    "stack": lambda x: jnp.stack([x, 2.0 * x], axis=1),
}
RIGS = {"wheel": wheel, "platform": platform, "reaction": reaction, "joint": joint, "two_axis": two_axis}


def test_every_primitive_is_tried() -> None:
    assert {*EACH} == {*RULES}


@pytest.mark.parametrize("name", EACH)
def test_a_primitive_does_what_jax_does(name: str) -> None:
    closed = jax.make_jaxpr(EACH[name])(X)
    assert name in [q.name for q in flattened(closed).equations]
    found = worked_out(closed, [X])
    wanted = jax.tree.leaves(EACH[name](jnp.asarray(X)))
    assert len(found) == len(wanted)
    for a, b in zip(found, wanted, strict=True):
        assert a.shape == b.shape and a.dtype == b.dtype
        assert a == pytest.approx(np.asarray(b), rel=1e-14, abs=1e-16)


def test_what_is_not_there_is_refused_by_its_name() -> None:
    with pytest.raises(Unsupported, match="sort"):
        worked_out(jax.make_jaxpr(jnp.sort)(X), [X])


def test_a_reshape_that_also_transposes_is_refused() -> None:
    closed = jax.make_jaxpr(lambda a: jax.lax.reshape(a, (24,), (2, 0, 1)))(M)
    with pytest.raises(Unsupported, match="transposes"):
        worked_out(closed, [M])


def _linear_part(structure: Structure) -> Callable:
    return lambda theta: linear_part(plant_of(structure, theta))


@pytest.mark.parametrize("kind", RIGS)
def test_the_linear_part_of_every_plant_is_worked_out(kind: str) -> None:
    bare = structure_of(RIGS[kind]())
    for structure in [bare, *(bare.with_effects(name) for name in of_kind(kind))]:
        theta = 0.7 + 0.1 * np.arange(len(structure.names))
        (found,) = worked_out(jax.make_jaxpr(_linear_part(structure))(theta), [theta])
        n = len(structure.states)
        assert found.shape == (n, n) and np.isfinite(found).all() and found.any(), structure.effects


@pytest.mark.parametrize("kind", RIGS)
def test_its_linear_part_is_that_of_jax(kind: str) -> None:
    structure = structure_of(RIGS[kind]())
    theta = 0.7 + 0.1 * np.arange(len(structure.names))
    (found,) = worked_out(jax.make_jaxpr(_linear_part(structure))(theta), [theta])
    wanted = np.asarray(_linear_part(structure)(jnp.asarray(theta)))
    assert found == pytest.approx(wanted, rel=1e-12) and np.array_equal(found != 0.0, wanted != 0.0)
