"""Ctrl-C, or SIGTERM, while something must not be left half-done: noted first, heeded at the next read."""

import signal
import threading
import time

PATIENCE_S = 2.0
"""Time [s] after a first Ctrl-C from which another one leaves what does not end by itself, such as a disk that takes nothing."""


class CtrlC:
    """Meanwhile Ctrl-C, which always reaches the main thread, is only noted: whatever it meets is not left half-done.

    One that comes `PATIENCE_S` after the first is a `KeyboardInterrupt`. In another thread, or where the program ignores
    Ctrl-C, nothing is done. SIGTERM counts as Ctrl-C where the program handles it, as the command `rwjax` does.

    Attributes:
        pressed: Whether it has come.
        number: Which of the two has come first.
    """

    def __init__(self) -> None:
        self.pressed, self.number, self._since = False, signal.SIGINT, 0.0
        self._heard: list[signal.Signals] = []
        if threading.current_thread() is threading.main_thread():
            self._heard += [signal.SIGINT] * (signal.getsignal(signal.SIGINT) is not signal.SIG_IGN)
            self._heard += [signal.SIGTERM] * callable(signal.getsignal(signal.SIGTERM))

    def __enter__(self) -> "CtrlC":
        self._before = [signal.signal(number, self._note) for number in self._heard]
        return self

    def __exit__(self, *_: object) -> None:
        for number, before in zip(self._heard, self._before, strict=True):
            signal.signal(number, before or signal.SIG_DFL)  # None: set by a program that is not Python

    def heed(self) -> None:
        """After the context: what came within is told to the program, whose own handler may want something else than to end."""
        if self.pressed:
            signal.raise_signal(self.number)

    def _note(self, number: int, _: object) -> None:
        now = time.monotonic()
        if self.pressed and now - self._since >= PATIENCE_S:
            raise KeyboardInterrupt
        if not self.pressed:
            self.pressed, self.number, self._since = True, signal.Signals(number), now
