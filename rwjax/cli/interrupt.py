"""Ctrl-C in the command, and SIGTERM alike: one line and no traceback, wherever it comes.

Within the import of a library it ends the process at once. Raised there, a `KeyboardInterrupt` comes out as the library's own
error, is swallowed, or crashes what is being set up. Anywhere else it is a `KeyboardInterrupt`, which lets the commands tidy up.

The room imports this module before anything else.
"""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType

SAYS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
"""What the command says that ends by Ctrl-C, and by what `kill` and `timeout` send."""
SIGNALS = tuple(SAYS)
"""Signals that end the command: one is as good a reason as the other."""
_last_signal = signal.SIGINT
"""The one that came last: typer turns it into exit 130 and forgets which signal came."""
NO_ANSWER = "; there is no answer yet, and nothing was written"
"""What the command says besides where its answer was still to come."""
_no_answer = ""
"""That, while it is."""
STATUS = 128 + signal.SIGINT
"""Status that typer makes of a `KeyboardInterrupt`, whatever it was raised for."""
CLEAR = "\r\x1b[K\x1b[?25h"
"""What a terminal is told on which a live view may have left a line and hidden the cursor."""
SAME_S = 1.0
"""Time [s] within which another one says the same again: `timeout` sends its own to the program, and then to its whole group."""

ASKED = "rwjax: stopping; the answer so far follows (Ctrl-C, or SIGTERM, again leaves at once)"
"""What the first of `SIGNALS` says where there is an answer to come."""


def leave() -> None:
    """Says what came and ends the process at once: threads may be inside compiled code, which must not be torn down under them.

    The status is the usual one of a program that a signal ended, 130 or 143.
    """
    said = f"{CLEAR if os.isatty(2) else ''}rwjax: {SAYS[_last_signal]}{_no_answer}"
    with suppress(Exception):  # closed, full, or being written to where the program was interrupted
        sys.stdout.flush()
    try:
        sys.stderr.write(f"{said}\n")
        sys.stderr.flush()
    except Exception:
        with suppress(OSError):
            os.write(2, f"{said}\n".encode())
    os._exit(128 + _last_signal)


def heard(number: int, frame: FrameType | None) -> None:
    """Handles one of `SIGNALS`.

    Args:
        number: of the signal.
        frame: of the program, where it was interrupted.

    Raises:
        KeyboardInterrupt: unless a library is being imported.
    """
    _note(number)
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            leave()
        frame = frame.f_back
    raise KeyboardInterrupt


def _note(number: int) -> None:
    global _last_signal
    _last_signal = signal.Signals(number)


@contextmanager
def first(ask: Callable[[], bool]) -> Iterator[None]:
    """What the first of `SIGNALS` does in place of an interruption; one that comes `SAME_S` later is as everywhere.

    Args:
        ask: asks for the answer so far; False where there is none to come, so that the program is interrupted.

    Yields:
        Nothing.
    """

    def asked(number: int, frame: FrameType | None) -> None:
        _note(number)
        since = time.monotonic()

        def again(number: int, frame: FrameType | None) -> None:
            if time.monotonic() - since >= SAME_S:
                heard(number, frame)

        _handle(ours, again)
        if not ask():
            heard(number, frame)
        with suppress(OSError):
            os.write(2, f"{CLEAR if os.isatty(2) else ''}{ASKED}\n".encode())

    ours = _heard()  # none in a program that imports the library
    _handle(ours, asked)
    try:
        yield
    finally:
        _handle(ours, heard)


@contextmanager
def unanswered() -> Iterator[Callable[[], None]]:
    """Within this, one of `SIGNALS` that ends the command says that there is no answer yet.

    Yields:
        Function that ends that, when there is an answer.
    """
    _say_no_answer(NO_ANSWER)
    try:
        yield lambda: _say_no_answer("")
    except KeyboardInterrupt:  # which `main` turns into the line
        raise
    except BaseException:
        _say_no_answer("")
        raise
    _say_no_answer("")


def _say_no_answer(words: str) -> None:
    global _no_answer
    _no_answer = words


def begin() -> None:
    """Handles `SIGNALS` from here on, if this is the command `rwjax` or `python -m rwjax` and no program that imports the library.

    One that is ignored, as Ctrl-C is in a script's background, stays so.
    """
    usual = signal.default_int_handler, signal.SIG_DFL
    if _is_command() and (ours := [number for number in SIGNALS if signal.getsignal(number) in usual]):
        _handle(ours, heard)
        sys.excepthook = _uncaught
        sys.unraisablehook = _unraisable


def end() -> None:
    """From here on `SIGNALS` do nothing: the work is done, and what is left is the end of the process."""
    _handle(_heard(), signal.SIG_IGN)


def _heard() -> list[signal.Signals]:
    """Those of `SIGNALS` that the command handles."""
    return [number for number in SIGNALS if signal.getsignal(number) is heard]


def _handle(numbers: Iterable[signal.Signals], by: Callable[[int, FrameType | None], None] | signal.Handlers) -> None:
    for number in numbers:
        signal.signal(number, by)


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
