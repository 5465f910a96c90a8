"""The Dask cluster that carries a fleet out: one of this machine's own, or one that runs already."""

import logging
import os
import signal
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from multiprocessing.resource_tracker import ensure_running
from typing import TYPE_CHECKING, Any

from rwjax.errors import InputError, one_line
from rwjax.fitting.threads import THREADS, VARIABLE
from rwjax.link.ctrl_c import CtrlC

if TYPE_CHECKING:
    from distributed import Client

WAITS_S = 15.0
"""How long a scheduler that does not answer is waited for [s]."""
NO_PAUSE = {"distributed.worker.memory.pause": False}
"""A process that Dask pauses near its limit has one job alone, and nothing that could free its memory: it would wait for ever."""
LEAST_MIB = 256
"""Memory of a process at least [MiB]: rwjax alone takes 217 where it is loaded, and a process that takes its limit is ended again and again."""
LOGGERS = (
    "distributed",
    *(f"distributed.{part}" for part in ("client", "core", "nanny", "scheduler", "utils", "worker")),
)
"""What of Dask writes lines of its own: workers that come and go are its daily business, and what goes wrong is said in its place."""


@contextmanager
def connected(scheduler: str | None, workers: int | None, memory: str | None) -> "Iterator[Client]":
    """A client of a cluster that has a worker.

    Args:
        scheduler: Address of a scheduler that runs already; None for a cluster of this machine's own, which ends with the context.
        workers: Processes of an own cluster, each with one thread; as many as there are processors without it [1].
        memory: Memory of each of them, as "2GiB", its share of what there is without it; a worker that takes more gives way to a new one.

    Yields:
        The client.

    Raises:
        InputError: No scheduler answers, it has no worker, the memory is no size or too little, or Dask is not installed.
    """
    try:
        from dask import config

        with config.set(logging=dict.fromkeys(LOGGERS, "critical")):  # read when `distributed` is first imported
            from distributed import Client, LocalCluster
    except ImportError:
        raise InputError("a fleet needs Dask: pip install 'distributed>=2026.8'") from None
    limit = "auto" if memory is None else _size(memory)
    with config.set({"distributed.comm.timeouts.connect": WAITS_S} | NO_PAUSE), ExitStack() as both:
        if scheduler is not None:
            _check(scheduler)
        address: Any = scheduler
        if scheduler is None:
            with _undisturbed():
                own = LocalCluster(
                    n_workers=workers or THREADS,
                    threads_per_worker=1,
                    memory_limit=limit,
                    silence_logs=logging.CRITICAL,
                    dashboard_address=":0",  # any free port
                    env=os.environ | {VARIABLE: "1"},
                )
                address = both.enter_context(own)
        try:
            client = both.enter_context(Client(address, timeout=WAITS_S, set_as_default=False))
        except (OSError, ValueError) as error:
            said = f"--scheduler {scheduler}: does not answer ({one_line(str(error))})"
            raise InputError(f"{said}; start one with `dask scheduler`") from None
        try:
            client.wait_for_workers(1, timeout=WAITS_S)
        except TimeoutError:
            raise InputError(f"--scheduler {scheduler}: has no worker; start one with `dask worker`") from None
        yield client


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Keeps Ctrl-C from the threads and processes that begin within, for as long as they live; what begins is whole before it is heeded."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    ensure_running()  # as it begins, Python's tracker of resources lets Ctrl-C through again
    with CtrlC() as ctrl_c:
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
    ctrl_c.heed()


def _size(memory: str) -> int:
    """Bytes of a size in words. Raises `InputError` for one that is none, or with which no process could begin."""
    from dask.utils import parse_bytes

    try:
        found = parse_bytes(memory)
    except ValueError:
        raise InputError(f"--memory {memory}: is no size; write one as 2GiB") from None
    if found < LEAST_MIB * 2**20:
        raise InputError(f"--memory {memory}: a process needs {LEAST_MIB} MiB at least; write one as 2GiB")
    return found


def _check(scheduler: str) -> None:
    """Raises `InputError` where nothing listens at an address; Dask itself asks for long, and says much."""
    start = "start one with `dask scheduler`"
    kind, _, place = scheduler.rpartition("://")
    host, _, port = place.rpartition(":")
    if kind not in ("", "tcp", "tls") or not host or not port.isdigit():
        raise InputError(f"--scheduler {scheduler}: is no address; write one as tcp://host:8786")
    end = time.monotonic() + WAITS_S
    while True:
        try:
            return socket.create_connection((host.strip("[]"), int(port)), timeout=WAITS_S).close()
        except (OSError, OverflowError) as error:  # one that is started again needs seconds to listen
            if time.monotonic() > end:
                raise InputError(f"--scheduler {scheduler}: does not answer ({error}); {start}") from None
            time.sleep(0.5)
