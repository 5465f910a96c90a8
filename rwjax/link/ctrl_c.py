"""Ctrl-C while something must not be left half-done: noted first, heeded at the next read."""

import signal
import threading
import time

PATIENCE_S = 2.0
"""Time [s] after a first Ctrl-C from which another one leaves what does not end by itself, such as a disk that takes nothing."""


class CtrlC:
    """Meanwhile Ctrl-C, which always reaches the main thread, is only noted: whatever it meets is not left half-done.

    One that comes `PATIENCE_S` after the first is a `KeyboardInterrupt`. In another thread, or where the program ignores
    Ctrl-C, nothing is done.

    Attributes:
        pressed: Whether it has come.
    """

    def __init__(self) -> None:
        self.pressed, self._since = False, 0.0
        in_main_thread = threading.current_thread() is threading.main_thread()
        self._heard = in_main_thread and signal.getsignal(signal.SIGINT) is not signal.SIG_IGN

    def __enter__(self) -> "CtrlC":
        if self._heard:
            self._before = signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        if self._heard:
            signal.signal(signal.SIGINT, self._before or signal.SIG_DFL)  # None: set by a program that is not Python

    def _note(self, *_: object) -> None:
        now = time.monotonic()
        if self.pressed and now - self._since >= PATIENCE_S:
            raise KeyboardInterrupt
        if not self.pressed:
            self.pressed, self._since = True, now
