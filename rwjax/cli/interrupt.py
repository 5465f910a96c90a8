"""Ctrl-C in the command: one line and no traceback, wherever it comes.

Within the import of a library it ends the process at once. Raised there, a `KeyboardInterrupt` comes out as the library's own
error, is swallowed, or crashes what is being set up. Anywhere else it is a `KeyboardInterrupt`, which lets the commands tidy up.

The room imports this module before anything else.
"""

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType

STATUS = 130
"""Status of a program that Ctrl-C ended."""
CLEAR = "\r\x1b[K\x1b[?25h"
"""What a terminal is told on which a live view may have left a line and hidden the cursor."""

ASKED = "rwjax: stopping; the answer so far follows (Ctrl-C again leaves at once)"
"""What the first Ctrl-C says where there is an answer to come."""


def leave() -> None:
    """Says so and ends the process at once: threads may be inside compiled code, which must not be torn down under them."""
    said = (CLEAR if os.isatty(2) else "") + "rwjax: interrupted"
    with suppress(Exception):  # closed, full, or being written to where the program was interrupted
        sys.stdout.flush()
    try:
        sys.stderr.write(f"{said}\n")
        sys.stderr.flush()
    except Exception:
        with suppress(OSError):
            os.write(2, f"{said}\n".encode())
    os._exit(STATUS)


def heard(number: int, frame: FrameType | None) -> None:
    """Handles Ctrl-C.

    Args:
        number: of the signal.
        frame: of the program, where it was interrupted.

    Raises:
        KeyboardInterrupt: unless a library is being imported.
    """
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            leave()
        frame = frame.f_back
    raise KeyboardInterrupt


@contextmanager
def first(ask: Callable[[], bool]) -> Iterator[None]:
    """What the first Ctrl-C does in place of an interruption; the next one is as everywhere.

    Args:
        ask: asks for the answer so far; False where there is none to come, so that the program is interrupted.

    Yields:
        Nothing.
    """

    def asked(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, heard)
        if not ask():
            heard(number, frame)
        with suppress(OSError):
            os.write(2, f"{CLEAR if os.isatty(2) else ''}{ASKED}\n".encode())

    if signal.getsignal(signal.SIGINT) is not heard:  # a program that imports the library
        yield
        return
    signal.signal(signal.SIGINT, asked)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, heard)


def begin() -> None:
    """Handles Ctrl-C from here on, if this is the command `rwjax` or `python -m rwjax` and no program that imports the library."""
    if _is_command() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, heard)
        sys.excepthook = _uncaught
        sys.unraisablehook = _unraisable


def end() -> None:
    """From here on Ctrl-C does nothing: the work is done, and what is left is the end of the process."""
    if signal.getsignal(signal.SIGINT) is heard:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _uncaught(kind: type[BaseException], error: BaseException, where: TracebackType | None) -> None:
    """Also before and after `main`."""
    if issubclass(kind, KeyboardInterrupt):
        leave()
    sys.__excepthook__(kind, error, where)


def _unraisable(lost: "sys.UnraisableHookArgs") -> None:
    """Also where Python would go on, such as in what the garbage collector calls."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        leave()
    sys.__unraisablehook__(lost)


def _is_command() -> bool:
    program, *given = sys.argv or [
        ""
    ]  # a process that `multiprocessing` begins takes it over, but was not begun with it
    own = sys.orig_argv[: len(sys.orig_argv) - len(given)]  # what Python itself was given, up to the program
    is_script = own[-1:] == [program] and os.path.splitext(os.path.basename(program))[0] == "rwjax"
    return is_script or own[-2:] == ["-m", "rwjax"]


begin()
