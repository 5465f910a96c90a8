"""The command `rwjax` in processes of their own that begin with all modules read: each is a fork of one server.

So a command costs what it does, without the two seconds that reading the modules takes.
"""

import multiprocessing
import os
import resource
import signal
import sys
from multiprocessing.process import BaseProcess
from pathlib import Path

SERVER = multiprocessing.get_context("forkserver")
SERVER.set_forkserver_preload(
    [
        *(
            "tests.damage.process",
            "rwjax.cli.main",
            "rwjax.fitting.fit",
            "rwjax.fitting.predict",
            "rwjax.methods.comparison",
        ),
        *(
            "rwjax.methods.two_stage",
            "rwjax.methods.limit_speeds",
            "rwjax.diagnosis.diagnosis",
            "rwjax.control.region",
            "rwjax.control.sweep",
        ),
        *("rwjax.control.gain_design", "rwjax.control.slew", "rwjax.control.sizing", "rwjax.control.momentum_dump"),
        *("rwjax.planning.campaign", "rwjax.report.html", "rwjax.report.plots", "rwjax.report.comparison"),
        *("rwjax.report.region", "rwjax.report.control", "rwjax.link.recorder", "rwjax.link.play_plan"),
    ]
)


def start(
    arguments: list[str], folder: Path, out: Path, err: Path | str, *, most_bytes: int | None = None
) -> BaseProcess:
    """Starts a command in a folder; what it says goes to files or to a terminal.

    Of `most_bytes`, no file that it writes becomes longer, as on a full disk.
    """
    process = SERVER.Process(target=_run, args=(arguments, str(folder), str(out), str(err), most_bytes))
    process.start()
    return process


def _run(arguments: list[str], folder: str, out: str, err: str, most_bytes: int | None) -> None:
    """The command, as the console script begins it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.chdir(folder)
    for number, path in ((0, os.devnull), (1, out), (2, err)):
        opened = os.open(
            path, os.O_RDWR | os.O_NOCTTY | (0 if path.startswith("/dev/") else os.O_CREAT | os.O_TRUNC), 0o600
        )
        os.dup2(opened, number)
        os.close(opened)
    sys.stdin, sys.stdout, sys.stderr = (os.fdopen(n, mode, encoding="utf-8", errors=how) for n, mode, how in STREAMS)
    sys.argv = ["rwjax", *arguments]
    if most_bytes is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
    from rwjax.cli.main import main

    main()


STREAMS = ((0, "r", "strict"), (1, "w", "strict"), (2, "w", "backslashreplace"))
"""Number, mode and what is done with characters that cannot be encoded, as Python opens its own."""
