"""Parts: frozen dataclasses whose numbers JAX traces and whose static fields decide which program is compiled."""

import pickle
from abc import abstractmethod
from dataclasses import FrozenInstanceError, fields, replace

import jax
import jax.numpy as jnp
import pytest

from rwjax.effects.part import Part, static
from rwjax.types import Scalar


class Gain(Part):
    """A factor."""

    k: Scalar | float

    @abstractmethod
    def of(self, x: Scalar) -> Scalar:
        """What becomes of a number."""


class Power(Gain):
    """A factor and a power."""

    name: str = static()
    more: dict[str, Scalar] | None = None

    def of(self, x: Scalar) -> Scalar:
        """What becomes of a number."""
        return self.k * x ** {"square": 2, "cube": 3}[self.name]


def test_every_class_is_a_frozen_dataclass_with_the_fields_of_its_base_first() -> None:
    assert [f.name for f in fields(Power)] == ["k", "name", "more"]
    part = Power(2.0, "square")
    with pytest.raises(FrozenInstanceError):
        part.k = 3.0  # pyright: ignore[reportAttributeAccessIssue]
    assert replace(part, name="cube").name == "cube"


def test_what_a_base_asks_for_has_to_be_there() -> None:
    with pytest.raises(TypeError, match="abstract"):
        Gain(1.0)  # pyright: ignore[reportAbstractUsage]


@pytest.mark.parametrize("name", ["__init__", "__post_init__", "__check_init__"])
def test_a_constructor_of_its_own_is_refused_by_its_name(name: str) -> None:
    with pytest.raises(TypeError, match=rf"Own\.{name}: a part has no constructor of its own"):
        type("Own", (Gain,), {name: lambda self: None})


def test_another_process_gets_it_whole() -> None:
    part = pickle.loads(pickle.dumps(Power(2.0, "cube")))
    assert isinstance(part, Power) and (part.k, part.name, part.more) == (2.0, "cube", None)


def test_numbers_are_leaves_and_static_fields_are_not() -> None:
    part = Power(jnp.asarray(2.0), "square", {"b": jnp.asarray(1.0)})
    assert len(jax.tree.leaves(part)) == 2
    halved = jax.tree.map(lambda a: 0.5 * a, part)
    assert isinstance(halved, Power) and float(halved.k) == 1.0 and halved.name == "square"


def test_it_is_traced_once_for_all_numbers_and_again_for_another_static_field() -> None:
    traced = []

    @jax.jit
    def of(part: Power, x: Scalar) -> Scalar:
        traced.append(part.name)
        return part.of(x)

    x = jnp.asarray(3.0)
    found = [float(of(Power(jnp.asarray(k), name), x)) for k, name in ((1.0, "square"), (2.0, "square"), (1.0, "cube"))]
    assert found == [9.0, 18.0, 27.0] and traced == ["square", "cube"]


def test_it_is_differentiated_by_its_numbers() -> None:
    slope = jax.grad(lambda part: part.of(jnp.asarray(3.0)))(Power(jnp.asarray(2.0), "cube"))
    assert isinstance(slope, Power) and float(slope.k) == 27.0
