"""Part: a frozen dataclass that JAX can look into, the base of plants and effects."""

from abc import ABC
from dataclasses import dataclass, field, fields
from typing import Any, dataclass_transform

import jax

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

    It does what a module of equinox does, of which every look-up of a method takes longer than to trace what the method works out.
    """

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        held = fields(dataclass(frozen=True, eq=False)(cls))  # pyright: ignore[reportArgumentType]
        unchanging = [f.name for f in held if f.metadata.get(STATIC)]
        traced = [f.name for f in held if f.name not in unchanging]
        jax.tree_util.register_dataclass(cls, data_fields=traced, meta_fields=unchanging)
