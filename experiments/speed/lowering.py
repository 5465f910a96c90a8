"""The yardstick of the library's compiled loops: the same loops as programs of XLA."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")
XLA = "XLA's programs"
"""How tables call the yardstick."""


@contextmanager
def xla_only() -> Iterator[None]:
    """Inside, the library's loops are XLA's programs, also in processes that start inside.

    The library knows no others yet. With a second lowering, its switch belongs here and nowhere else in this folder.
    """
    yield


def by_xla(call: Callable[..., T]) -> Callable[..., T]:
    """The same call inside `xla_only`."""

    def inside(*arguments: object) -> T:
        with xla_only():
            return call(*arguments)

    return inside
