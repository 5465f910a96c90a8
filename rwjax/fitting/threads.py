"""TODO."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from threading import Lock
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController

T = TypeVar("T")

THREADS = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _OneThread:
    """Keeps the matrix products of numpy and scipy on one thread, in the whole process, while any thread is within: theirs
    would wait for the next product busily, on the cores that the runs need."""

    def __init__(self) -> None:
        self.within, self.limit = 0, None
        self.lock = Lock()

    def __enter__(self) -> None:
        with self.lock:
            self.within += 1
            if self.limit is None:
                self.limit = ThreadpoolController().limit(limits=1, user_api="blas")

    def __exit__(self, *error: object) -> None:
        with self.lock:
            self.within -= 1
            if self.limit is not None and not self.within:
                self.limit.restore_original_limits()
                self.limit = None


ONE_THREAD = _OneThread()


@contextmanager
def pool_of_threads() -> Iterator[ThreadPoolExecutor]:
    """Threads that an error or Ctrl-C does not wait for."""
    pool = ThreadPoolExecutor(THREADS)
    try:
        with ONE_THREAD:
            yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def on_threads(function: Callable[..., T], *arguments: Sequence[Any]) -> list[T]:
    """What a function makes of each row of arguments, which are computed at the same time."""
    with pool_of_threads() as pool:
        return list(pool.map(function, *arguments))
