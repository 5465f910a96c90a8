"""Budget of a diagnosis: when its search has to end, by the clock or because somebody wants the answer so far.

The search asks between two batches of free runs. Where the budget has ended it leaves by `Stopped`. Fits are taken down after a batch
alone, so what was found until then is whole.
"""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from numbers import Real
from threading import Event
from typing import TypeVar

from rwjax.errors import InputError
from rwjax.fitting.batched_runs import Simulating

T = TypeVar("T")


class Stopped(Exception):
    """The budget has ended, and with it the search."""


class Budget:
    """Time that a diagnosis may search, from the moment at which the budget is made.

    Attributes:
        seconds: the time [s], infinite for no limit.
    """

    def __init__(self, seconds: float = math.inf, clock: Callable[[], float] = time.monotonic) -> None:
        if not isinstance(seconds, Real) or not seconds > 0.0:
            raise InputError(f"budget {seconds}: has to be a positive number of seconds; inf is no limit")
        self.seconds = seconds
        self._clock = clock
        self._begun = clock()
        self._asked = Event()
        self._searched = False  # whether a search has begun
        self._searching = False
        self._kept = 0.0  # of the budget for what comes after the search that is under way [s]

    def stop(self) -> bool:
        """Ends the search as soon as can be, from any thread or a signal's handler.

        Returns:
            Whether a search has begun, so that there is an answer to come.
        """
        self._asked.set()
        return self._searched

    @property
    def stopped(self) -> bool:
        """Whether somebody has asked for the answer so far."""
        return self._asked.is_set()

    @property
    def left(self) -> float:
        """Time that is left of the whole budget [s]."""
        return self._left(0.0)

    def _left(self, kept: float) -> float:
        return 0.0 if self.stopped else max(self.seconds - kept - (self._clock() - self._begun), 0.0)

    @contextmanager
    def searching(self) -> Iterator[None]:
        """What the budget limits. Outside of it `check` does nothing: the answer itself is always worked out.

        Yields:
            Nothing.
        """
        self._searched = self._searching = True
        try:
            yield
        finally:
            self._searching, self._kept = False, 0.0

    def keep(self, share: float) -> None:
        """Keeps a part of the budget for a further search, which judges what the one under way has come to: that one ends sooner.

        Args:
            share: the part, of the whole budget [1]; of one without a limit nothing is kept.
        """
        self._kept = share * self.seconds if math.isfinite(self.seconds) else 0.0

    def check(self) -> None:
        """Ends the search where the budget has ended.

        Raises:
            Stopped: it has.
        """
        if self._searching:
            _ended(self._left(self._kept))

    def ending(self) -> Callable[[], None]:
        """What ends work for this search on another thread, also after the search itself has left; the search's own thread asks for it.

        Returns:
            A function that raises `Stopped` where this search's part of the budget has ended.
        """
        kept = self._kept
        return lambda: _ended(self._left(kept))

    def heeded(self, search: Simulating[T]) -> Simulating[T]:
        """The same search, which ends with the budget.

        Args:
            search: free runs that it waits for, and its result.

        Yields:
            Free runs to simulate.

        Returns:
            The search's result.

        Raises:
            Stopped: the budget has ended.
        """
        readings = None
        while True:
            self.check()
            try:
                wanted = next(search) if readings is None else search.send(readings)
            except StopIteration as end:
                return end.value
            readings = yield wanted


def _ended(left: float) -> None:
    """Ends a search with no time left [s]."""
    if not left:
        raise Stopped
