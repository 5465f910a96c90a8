"""Part: a frozen dataclass that JAX can look into, the base of plants and effects."""

from abc import ABC
from dataclasses import dataclass, field, fields
from typing import Any, dataclass_transform

import jax

CONSTRUCTORS = ("__init__", "__post_init__", "__check_init__")
"""Methods that run when a part is made."""
STATIC = "static"
"""Key in a field's metadata: what it holds decides which program is compiled."""


def static() -> Any:
    """Field of a part that decides which program is compiled; every other field holds arrays and numbers, which may change without a new one.

    Returns:
        The field.
    """
    return field(metadata={STATIC: True})


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field, static))
class Part(ABC):  # noqa: B024 - the methods that every port has to have are in the classes derived from it
    """A part of a rig. Every class derived from it is a frozen dataclass, and a tree of arrays for JAX.

    JAX makes it anew from its fields wherever it looks into it, with what it traces in place of numbers. So a class has no constructor of
    its own, and nothing that runs after one. Two parts are equal where they are the same object. A module of equinox could do more, but to
    look up a method of one takes longer than to trace what the method works out.

    Raises:
        TypeError: a class derived from it has such a method.
    """

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if own := [name for name in CONSTRUCTORS if name in vars(cls)]:
            raise TypeError(
                f"{cls.__name__}.{own[0]}: a part has no constructor of its own, since JAX makes parts anew"
            )
        held = fields(dataclass(frozen=True, eq=False)(cls))  # pyright: ignore[reportArgumentType]
        unchanging = [f.name for f in held if f.metadata.get(STATIC)]
        traced = [f.name for f in held if f.name not in unchanging]
        jax.tree_util.register_dataclass(cls, data_fields=traced, meta_fields=unchanging)
