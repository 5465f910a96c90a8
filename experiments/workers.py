"""The processes that carry out a long run: of this machine, or of a Dask cluster that runs already.

`--scheduler tcp://host:8786` gives the work to a cluster. Each of its workers begins in a checkout of the same commit:
`PYTHONPATH=. RWJAX_THREADS=1 dask worker tcp://host:8786 --nworkers 8 --nthreads 1`.
"""

import argparse
import multiprocessing
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar

T = TypeVar("T")
EACH = 40
"""Jobs until a process, whose memory grows with every program, gives way to a new one."""
LOST = ("BrokenProcessPool", "KilledWorker")
"""Errors of jobs whose worker died."""


class Workers(NamedTuple):
    """Which processes do the work.

    Attributes:
        processes: How many of this machine [1].
        scheduler: Address of the Dask scheduler whose workers do it in their place.
    """

    processes: int = 2
    scheduler: str | None = None

    @classmethod
    def options(cls, parser: argparse.ArgumentParser, processes: int = 2) -> None:
        """Adds the options of a command that uses workers."""
        which = parser.add_mutually_exclusive_group()
        which.add_argument("--processes", type=int, default=processes, help="of this machine")
        which.add_argument(
            "--scheduler", metavar="ADDRESS", help="a Dask scheduler that runs already, as tcp://host:8786"
        )

    @classmethod
    def of(cls, given: argparse.Namespace) -> "Workers":
        """The workers that a command was given."""
        return cls(given.processes, given.scheduler)


@contextmanager
def pool(workers: Workers) -> Iterator[Executor]:
    """An executor whose jobs the workers do."""
    if workers.scheduler is None:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(workers.processes, context, _end_with_parent) as own:
            yield own
    else:
        from distributed import Client

        with Client(workers.scheduler, set_as_default=False) as client, client.get_executor(pure=False) as theirs:
            yield theirs


def done(work: Callable[..., T], jobs: Sequence[tuple[Any, ...]], workers: Workers) -> Iterator[T]:
    """What becomes of jobs, each the arguments of `work`, as they are done; one that is lost with its worker is said and left out."""
    at_once, lost = len(jobs) if workers.scheduler else EACH * workers.processes, 0
    for first in range(0, len(jobs), max(at_once, 1)):
        with pool(workers) as executor:
            waiting = [executor.submit(work, *job) for job in jobs[first : first + at_once]]
            for future in as_completed(waiting):
                try:
                    found = future.result()
                except Exception as error:
                    if type(error).__name__ not in LOST:
                        for other in waiting:
                            other.cancel()
                        raise
                    lost += 1
                else:
                    yield found
    if lost:
        print(f"\n{lost} jobs were lost with a worker that died; run again for them")


def _end_with_parent() -> None:
    """Ends this worker when the run is killed, which leaves it no time to say so."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
