"""Ctrl-C while the program starts: one line and no traceback, also from within the import of a library.

The room imports it before anything else.
"""

import os
import signal
import sys
from types import FrameType

STATUS = 130
"""Status of a program that Ctrl-C ended."""


def leave(number: int = signal.SIGINT, frame: FrameType | None = None) -> None:
    """Says so and ends the process at once: threads may be inside compiled code, which must not be torn down under them.

    Args:
        number: of the signal, as a signal's handler gets it.
        frame: of the program, as a signal's handler gets it.
    """
    print("rwjax: interrupted", file=sys.stderr)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(STATUS)


def while_starting() -> None:
    """Ctrl-C ends the process, if that is the command `rwjax` or `python -m rwjax` and no program that imports the library."""
    if _is_command() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, leave)


def started() -> None:
    """From here on Ctrl-C is a `KeyboardInterrupt` again."""
    if signal.getsignal(signal.SIGINT) is leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _is_command() -> bool:
    if "-m" in sys.orig_argv:
        return sys.orig_argv[sys.orig_argv.index("-m") + 1] == "rwjax"
    program = (sys.argv or [""])[0]  # a process that `multiprocessing` begins takes it over, but was not begun with it
    return os.path.splitext(os.path.basename(program))[0] == "rwjax" and program in sys.orig_argv


while_starting()
