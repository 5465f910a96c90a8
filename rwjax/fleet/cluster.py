"""The Dask cluster that carries a fleet out: one of this machine's own, or one that runs already."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rwjax.errors import InputError
from rwjax.fitting.threads import THREADS, VARIABLE

if TYPE_CHECKING:
    from distributed import Client

WAITS_S = 30.0
"""How long a scheduler that does not answer is waited for [s]."""
LOGGERS = (
    "distributed",
    *(f"distributed.{part}" for part in ("client", "core", "nanny", "scheduler", "utils", "worker")),
)
"""What of Dask writes lines of its own: workers that come and go are its daily business, and what goes wrong is said in its place."""


@contextmanager
def connected(scheduler: str | None, workers: int | None, memory: str) -> "Iterator[Client]":
    """A client of a cluster.

    Args:
        scheduler: Address of a scheduler that runs already; None for a cluster of this machine's own, which ends with the context.
        workers: Processes of an own cluster, each with one thread; as many as there are processors without it.
        memory: Memory of each of them, as "2GiB" or "auto": a worker that takes more gives way to a new one.

    Yields:
        The client.

    Raises:
        InputError: No scheduler answers, or `distributed` is not installed.
    """
    try:
        from dask import config

        with config.set(logging=dict.fromkeys(LOGGERS, "critical")):  # read when `distributed` is first imported
            from distributed import Client, LocalCluster
    except ImportError:
        raise InputError("a fleet needs Dask: pip install 'rwjax[fleet]'") from None
    with config.set({"distributed.comm.timeouts.connect": WAITS_S}):
        if scheduler is not None:
            try:
                client = Client(scheduler, timeout=WAITS_S, set_as_default=False)
            except (OSError, ValueError) as error:
                raise InputError(
                    f"--scheduler {scheduler}: does not answer ({error}); start one with `dask scheduler`"
                ) from None
            try:
                yield client
            finally:
                client.close()
            return
        with (
            LocalCluster(
                n_workers=workers or THREADS,
                threads_per_worker=1,
                memory_limit=memory,
                dashboard_address=None,  # pyright: ignore[reportArgumentType]
                env=os.environ | {VARIABLE: "1"},
            ) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            yield client
