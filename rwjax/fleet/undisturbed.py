"""What a worker of an own cluster loads first: Ctrl-C on the terminal reaches it as well, and the client alone is to answer it."""

import signal


def dask_setup(worker: object) -> None:
    """Lets the worker's process ignore Ctrl-C; the client ends it. Dask calls this as the worker begins.

    Args:
        worker: The worker.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
