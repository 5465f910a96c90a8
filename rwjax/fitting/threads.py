"""Threads for work that runs at the same time, each with its matrix products on a single thread."""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ContextDecorator, contextmanager
from threading import Lock
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController

T = TypeVar("T")

VARIABLE = "RWJAX_THREADS"
"""Environment variable with the threads of a process; one of many on a machine takes 1."""


def _threads() -> int:
    """What the variable says, or the processors that this process may use."""
    given = os.environ.get(VARIABLE, "")
    if given.isascii() and given.isdigit() and int(given) > 0:
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


THREADS = _threads()
"""Threads of a pool."""


class SingleThreadedBlas(ContextDecorator):
    """Context in which the matrix products of numpy and scipy take one thread, in the whole process.

    The threads of a BLAS library wait busily for the next product, on the cores that the simulations need, and their
    number changes the last digits of a product. The limit ends when the last thread leaves the context. It decorates what
    has to give the same bytes on any number of processors.
    """

    def __init__(self) -> None:
        self._inside, self._limit = 0, None
        self._libraries, self._modules = None, 0
        self._lock = Lock()

    def __enter__(self) -> None:
        with self._lock:
            self._inside += 1
            if self._limit is None:
                self._limit = self._found().limit(limits=1, user_api="blas")

    def __exit__(self, *error: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._limit is not None and not self._inside:
                self._limit.restore_original_limits()
                self._limit = None

    def _found(self) -> ThreadpoolController:
        """The BLAS libraries of this process: an import alone brings new ones, and to look for them takes milliseconds."""
        if self._libraries is None or self._modules != len(sys.modules):
            self._libraries, self._modules = ThreadpoolController(), len(sys.modules)
        return self._libraries


SINGLE_THREADED_BLAS = SingleThreadedBlas()
"""The one context of this process: a second one would count its threads apart."""


@contextmanager
def pool_of_threads() -> Iterator[ThreadPoolExecutor]:
    """`THREADS` threads with single-threaded matrix products; an error or Ctrl-C does not wait for them.

    Yields:
        The pool, which is shut down at the end.
    """
    pool = ThreadPoolExecutor(THREADS)
    try:
        with SINGLE_THREADED_BLAS:
            yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def on_threads(function: Callable[..., T], *arguments: Sequence[Any]) -> list[T]:
    """Results of a function for every row of arguments, computed at the same time.

    Args:
        function: What to call.
        arguments: One sequence for each parameter of the function, all of the same length.

    Returns:
        Results in the order of the arguments.
    """
    with pool_of_threads() as pool:
        return list(pool.map(function, *arguments))
