"""The yardstick of the library's compiled loops: the same loops as programs of XLA."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from rwjax.lowering.kept import THROUGH_XLA

T = TypeVar("T")
XLA = "XLA's programs"
"""How tables call the yardstick."""


@contextmanager
def xla_only() -> Iterator[None]:
    """Inside, the library's loops are XLA's programs, also in processes that start inside."""
    before = os.environ.get(THROUGH_XLA)
    os.environ[THROUGH_XLA] = "1"
    try:
        yield
    finally:
        os.environ.pop(THROUGH_XLA)
        if before is not None:
            os.environ[THROUGH_XLA] = before


def by_xla(call: Callable[..., T]) -> Callable[..., T]:
    """The same call inside `xla_only`."""

    def inside(*arguments: object) -> T:
        with xla_only():
            return call(*arguments)

    return inside
