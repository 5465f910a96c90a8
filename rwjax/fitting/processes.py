"""Searches on several processes: what the threads of one Python do in turn, processes do at once.

A `Team` is this process and helpers. A few searches of one program stay together, since their free runs share batches; each
process takes those that come next. Nothing else changes: a search gives the same bytes wherever it runs.

A helper takes searches from its standard input and puts their results on its standard output, both by `pickle`. It ends with its
input. A problem is sent once; from then on a number stands for it, in both directions.
"""

import io
import logging
import os
import pickle
import subprocess
import sys
import traceback
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from queue import SimpleQueue
from threading import Lock, Thread
from typing import Any, BinaryIO, Generic, NamedTuple, TypeVar

import jax
import numpy as np

from rwjax.fitting.batched_runs import Simulating, together
from rwjax.fitting.garbage import seldom_collected
from rwjax.fitting.problem import Problem
from rwjax.fitting.threads import THREADS
from rwjax.simulation.shared_program import with_light_effects

T = TypeVar("T")
PIECE = 12
"""Searches of one program that stay together at most: their free runs fill several batches."""
LARGE = 4096
"""Size of an array from which on it is sent once, though several problems hold it [bytes]."""
MOST_HELPERS = 7
"""Helpers at most: each takes some 300 MB."""
DEFINED, SENT = b"d", b"s"
"""What stands before an object on a stream: whether a number stands for it from then on, or it is what was to be sent."""
HELPER = "import sys; sys.path[:] = sys.argv[1:]; from rwjax.fitting.processes import help_out; help_out()"


@dataclass(frozen=True)
class Task(Generic[T]):
    """A search that may run in another process.

    Attributes:
        problem: Logs and structure of its free runs.
        begin: Begins it: a function that `pickle` finds by its name, with its arguments.
    """

    problem: Problem
    begin: "partial[Simulating[T]]"


class _Ends:
    """This end of two streams between two processes, on which a number stands for a problem and for its large arrays."""

    def __init__(self, source: BinaryIO, sink: BinaryIO, *, defines: bool) -> None:
        self.source, self.sink, self.defines = source, sink, defines
        self.objects: list[Any] = []
        self.numbers: dict[int, int] = {}

    def send(self, message: object) -> None:
        """Sends an object, and before it those that it holds and that go by a number from now on."""
        data = self._pickled(message, (Problem,))
        self.sink.write(SENT + data)
        self.sink.flush()

    def receive(self) -> Any:
        """The next object; `EOFError` where the other process has ended."""
        while (kind := self.source.read(1)) == DEFINED:
            self._number(self._unpickled())
        if not kind:
            raise EOFError
        return self._unpickled()

    def _number(self, held: object) -> int:
        self.numbers[id(held)] = len(self.objects)
        self.objects.append(held)
        return len(self.objects) - 1

    def _number_of(self, part: object, kinds: tuple[type, ...]) -> int | None:
        """The number that stands for a part of what is sent; None for one that is sent as it is."""
        if not isinstance(part, kinds) or (isinstance(part, np.ndarray) and part.nbytes < LARGE):
            return None
        if id(part) not in self.numbers and self.defines:
            data = self._pickled(part, (Problem, np.ndarray))
            self.sink.write(DEFINED + data)
            self._number(part)
        return self.numbers.get(id(part))

    def _pickled(self, whole: object, kinds: tuple[type, ...]) -> bytes:
        buffer = io.BytesIO()
        pickler = pickle.Pickler(buffer, pickle.HIGHEST_PROTOCOL)
        pickler.persistent_id = lambda part: None if part is whole else self._number_of(part, kinds)
        pickler.dump(whole)
        return buffer.getvalue()

    def _unpickled(self) -> Any:
        unpickler = pickle.Unpickler(self.source)
        unpickler.persistent_load = self.objects.__getitem__
        return unpickler.load()


class _Failed(NamedTuple):
    """What a helper sends in the place of results."""

    error: BaseException


class _Helper:
    """Another process that carries searches out."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", HELPER, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"JAX_PLATFORMS": "cpu"},
            start_new_session=True,  # Ctrl-C is for this process alone
        )
        assert self.process.stdin and self.process.stdout
        self.ends = _Ends(self.process.stdout, self.process.stdin, defines=True)  # pyright: ignore[reportArgumentType]

    def carry_out(self, searches: Sequence[Task]) -> list[Any] | _Failed:
        """Results of searches."""
        self.ends.send([search.begin for search in searches])
        return self.ends.receive()

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        for stream in (self.ends.source, self.ends.sink):
            with suppress(OSError):  # what was not sent yet
                stream.close()


class Team:
    """This process and its helpers, which begin when they are first needed and end with its context.

    A team is for one diagnosis: it keeps the problems that were sent.

    Args:
        helpers: How many helpers at most; as many as there are further processors without it.
    """

    def __init__(self, helpers: int | None = None) -> None:
        self._most = min(THREADS - 1, MOST_HELPERS) if helpers is None else helpers
        self._helpers: list[_Helper] = []

    def __enter__(self) -> "Team":
        return self

    def __exit__(self, *error: object) -> None:
        self.end()

    def end(self) -> None:
        """Ends the helpers, whatever they are at; others begin when they are needed again."""
        while self._helpers:
            self._helpers.pop().end()

    def together(
        self,
        searches: Sequence[Task[T]],
        check: Callable[[], None] = lambda: None,
        heeded: Callable[[Simulating[T]], Simulating[T]] = lambda search: search,
        done: Callable[[int, T], None] = lambda number, found: None,
    ) -> list[T]:
        """Results of several searches.

        Args:
            searches: The searches.
            check: Called between searches; raises where they have to end.
            heeded: Wraps a search of this process, so that it ends within its work where searches have to end.
            done: Takes the number and the result of each that is done, on any thread.

        Returns:
            What each search returns, in the given order.

        Raises:
            Exception: The first error of any search, or what `check` or `done` raises; the helpers end with it.
        """

        def followed(number: int) -> Simulating[T]:
            found = yield from heeded(searches[number].begin())
            done(number, found)
            return found

        shared = _Shared(searches, done)
        if not self._begun(shared.for_helpers):
            return together([followed(k) for k in range(len(searches))])
        threads = [Thread(target=shared.hand_over, args=(helper,), daemon=True) for helper in self._helpers]
        own = max(THREADS - len(threads), 1)
        try:
            for thread in threads:
                thread.start()
            while any(thread.is_alive() for thread in threads) or shared.left:
                if (numbers := shared.next()) is not None:
                    found = together([followed(k) for k in numbers], threads=own)
                    shared.found |= zip(numbers, found, strict=True)
                else:
                    next((thread for thread in threads if thread.is_alive()), threads[0]).join(0.02)
                check()
                shared.raise_error()
            shared.raise_error()
        except BaseException:
            self.end()
            raise
        for helper in shared.lost:
            helper.end()
            self._helpers.remove(helper)
            self._most -= 1
        return [shared.found[k] for k in range(len(searches))]

    def _begun(self, pieces: int) -> bool:
        """Whether there are helpers for so many pieces that they may take, of which one is for this process."""
        if min(self._most, pieces - 1) < 1 or jax.default_backend() != "cpu" or getattr(sys, "frozen", False):
            return False
        while len(self._helpers) < min(self._most, pieces - 1):
            try:
                self._helpers.append(_Helper())
            except (OSError, TypeError):  # no further process, or no interpreter is known
                self._most = len(self._helpers)
        return bool(self._helpers)


ALONE = Team(0)
"""This process without helpers."""


class _Shared:
    """Searches that several processes share, in pieces of one program each."""

    def __init__(self, searches: Sequence[Task], done: Callable[[int, Any], None]) -> None:
        self.searches, self.done = searches, done
        alike: dict[object, list[int]] = {}
        for number, search in enumerate(searches):
            alike.setdefault(with_light_effects(search.problem.structure), []).append(number)
        self.left = deque(every[k : k + PIECE] for every in alike.values() for k in range(0, len(every), PIECE))
        self.found: dict[int, Any] = {}
        self.lost: list[_Helper] = []
        self._error: BaseException | None = None
        self._lock = Lock()

    @property
    def for_helpers(self) -> int:
        """How many pieces are left that a helper may take: it knows the library's effects and solvers alone."""
        return sum(self._is_for_helpers(numbers) for numbers in self.left)

    def _is_for_helpers(self, numbers: Sequence[int]) -> bool:
        problem = self.searches[numbers[0]].problem
        return problem.structure.from_library and problem.solver.from_library

    def next(self, *, by_helper: bool = False) -> list[int] | None:
        """Numbers of the searches of the next piece; none where nothing is left."""
        with self._lock:
            for numbers in self.left:
                if not by_helper or self._is_for_helpers(numbers):
                    self.left.remove(numbers)
                    return numbers
        return None

    def raise_error(self) -> None:
        """Raises what went wrong in a thread or in a helper."""
        if self._error:
            raise self._error

    def hand_over(self, helper: _Helper) -> None:
        """Has a helper carry searches out until none is left; what a helper that is lost had begun is left again."""
        while not self._error and (numbers := self.next(by_helper=True)) is not None:
            try:
                found = helper.carry_out([self.searches[k] for k in numbers])
            except Exception as error:  # reason: whatever keeps two processes apart, the work can be done in this one
                logging.getLogger("rwjax").info("a helper process is lost (%r); its work is done here", error)
                with self._lock:
                    self.lost.append(helper)
                    self.left.appendleft(numbers)
                return
            if isinstance(found, _Failed):
                self._error = found.error
                return
            try:
                for number, one in zip(numbers, found, strict=True):
                    self.found[number] = one
                    self.done(number, one)
            except BaseException as error:  # reason: it is raised in the thread that waits for the results
                self._error = error
                return


@seldom_collected()
def help_out() -> None:
    """What a helper does: it carries out what comes on its standard input, and ends with that at once."""
    source, sink = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what is printed is no result
    ends = _Ends(source, sink, defines=False)
    wanted: SimpleQueue[Any] = SimpleQueue()

    def listen() -> None:
        try:
            while True:
                wanted.put(ends.receive())
        finally:  # the other process has ended
            os._exit(0)

    Thread(target=listen, daemon=True).start()
    while True:
        searches = wanted.get()
        try:
            found = together([begin() for begin in searches], threads=1)
        except Exception as error:  # reason: it is raised in the process that has sent the search
            found = _Failed(_as_sent(error))
        ends.send(found)


def _as_sent(error: Exception) -> Exception:
    """An error that `pickle` can bring to another process, with the place where it was raised."""
    place = traceback.format_exc()
    try:
        again = pickle.loads(pickle.dumps(error))
    except Exception:  # reason: an error of any class may come
        again = RuntimeError(f"{type(error).__name__}: {error}")
    again.add_note(f"in a helper process:\n{place}")
    return again
