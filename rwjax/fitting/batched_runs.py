"""Free runs of many searches, simulated in batches.

A search is a generator: it yields a `Wanted`, which says what to simulate, and is sent the readings. All searches that
wait at a time share batches of `BATCH` free runs, each with its own log, parameter vector and initial state. A run in a
full batch costs a third of a call of its own.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import groupby
from threading import Condition
from typing import Any, NamedTuple, TypeVar

import numpy as np

from rwjax.fitting.problem import Problem
from rwjax.fitting.threads import THREADS, pool_of_threads
from rwjax.simulation.free_run import free_runs
from rwjax.simulation.shared_program import numbers_within

BATCH = 16
"""Free runs in one call."""


class Wanted(NamedTuple):
    """Free runs that a search waits for; it is sent their readings `(b, logs, windows, q, y)`, which it may overwrite.

    Attributes:
        problem: Logs and structure.
        theta: Parameter vectors `(b, t)`.
        start: Initial states `(b, l, n)` of all logs of the problem.
        logs: Numbers of the logs to simulate.
        windows: How many windows to simulate, from the first one on.
    """

    problem: Problem
    theta: np.ndarray
    start: np.ndarray
    logs: np.ndarray
    windows: int


T = TypeVar("T")
Simulating = Generator[Wanted, np.ndarray, T]
"""A search: yields what to simulate, is sent the readings, and returns its result."""


@dataclass
class _Request:
    """What the search numbered `search` waits for; `missing` runs of its readings `y` (runs, w, q, y) are still to come."""

    search: int
    wanted: Wanted
    y: np.ndarray = field(init=False)
    missing: int = field(init=False)

    def __post_init__(self) -> None:
        batch = self.wanted.problem.batch
        self.missing = len(self.wanted.theta) * len(self.wanted.logs)
        slots = batch.slot_step.shape[2]
        self.y = np.empty((self.missing, self.wanted.windows, slots, len(self.wanted.problem.structure.outputs)))

    @cached_property
    def program(self) -> int:
        """Number of the program and the batch: runs of the same one and of the same log may share a call."""
        batch = self.wanted.problem.batch
        return hash((self.code, self.wanted.windows, id(batch.slot_step), id(batch.u_command)))

    @cached_property
    def code(self) -> int:
        """Number of the machine code, which batches of other logs may share."""
        problem = self.wanted.problem
        return hash((problem.program, problem.solver, problem.batch.slot_step.shape))

    def given(self, runs: Sequence[int], log: int) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the plants of some runs of a log in their program `(r, q)`, and their first states `(r, n)` [SI]."""
        wanted, problem, b = self.wanted, self.wanted.problem, np.asarray(runs) // len(self.wanted.logs)
        own = wanted.theta[b][:, problem.batch.theta_index[log]] + problem.batch.theta_offset[log]
        return numbers_within(problem.program, problem.structure, own), wanted.start[b, log]

    def shared(self, run: int) -> tuple[int, int, int]:
        """What runs that may share a call have in common."""
        return self.code, self.program, int(self.wanted.logs[run % len(self.wanted.logs)])


called: set[int] = set()
"""Machine code that this process has called before: it need not be made."""
_Run = tuple[_Request, int]
"""A request and the number of the run in it."""


def _simulated(runs: list[_Run]) -> np.ndarray:
    """Readings of up to `BATCH` runs of one log."""
    first, run = runs[0]
    wanted, problem = first.wanted, first.wanted.problem
    log = int(wanted.logs[run % len(wanted.logs)])
    of_searches = (list(of) for _, of in groupby(runs, key=lambda one: one[0].search))
    given = zip(*(of[0][0].given([number for _, number in of], log) for of in of_searches), strict=True)
    numbers, start = (np.concatenate(part) for part in given)
    batch = problem.batch.of(log).with_own_numbers(numbers.shape[1])
    return free_runs(problem.program, numbers, start, wanted.windows, batch, solver=problem.solver)


def together(searches: Sequence[Simulating[T]], threads: int = THREADS) -> list[T]:
    """Results of several searches, whose free runs share batches.

    Args:
        searches: Generators that have not begun.
        threads: How many threads carry them out [1].

    Returns:
        What each generator returns, in the given order.

    Raises:
        Exception: The first error of any search; the others end with it.
    """
    schedule = _Schedule([*searches])
    with pool_of_threads() as pool:
        try:
            workers = [pool.submit(schedule.work) for _ in range(threads)]
            for worker in workers:
                worker.result()
        finally:
            schedule.stop()
    return [schedule.found[number] for number in range(len(searches))]


def by_itself(search: Simulating[T]) -> T:
    """Result of one search, on this thread: whoever asks may be one of several already.

    Args:
        search: A generator that has not begun.

    Returns:
        What it returns.
    """
    schedule = _Schedule([search])
    schedule.work()
    return schedule.found[0]


class _Schedule:
    """Shares work among threads.

    Each thread takes, in this order: runs that fill a batch; the search whose readings came last; the runs that wait. Runs of a program
    that another thread calls for the first time in this process are left until it is there: meanwhile this thread makes another program.
    """

    def __init__(self, searches: list[Simulating[Any]]) -> None:
        self.searches = searches
        self.found: dict[int, Any] = {}
        self.ready: list[tuple[int, np.ndarray | None]] = [(number, None) for number in reversed(range(len(searches)))]
        self.waiting: dict[tuple[int, int, int], list[_Run]] = {}
        self.in_the_making: set[int] = set()
        self.busy = 0
        self.stopped = False
        self.changed = Condition()

    def stop(self) -> None:
        """No thread starts further work."""
        with self.changed:
            self.stopped = True
            self.changed.notify_all()

    def work(self) -> None:
        """What one thread does, until nothing is left."""
        try:
            while (job := self._next()) is not None:
                job()
                with self.changed:
                    self.busy -= 1
                    self.changed.notify_all()
        except BaseException:
            self.stop()
            raise

    def _next(self) -> Callable[[], None] | None:
        with self.changed:
            while not self.stopped:
                held = (runs for shared, runs in self.waiting.items() if shared[0] not in self.in_the_making)
                fullest = max(held, key=len, default=[])
                if self.ready and len(fullest) < BATCH:
                    self.busy += 1
                    return partial(self._resume, *self.ready.pop())
                if fullest:
                    request, run = fullest[0]
                    shared = request.shared(run)
                    del self.waiting[shared]
                    if fullest[BATCH:]:
                        self.waiting[shared] = fullest[BATCH:]
                    if request.code not in called:
                        self.in_the_making.add(request.code)
                    self.busy += 1
                    return partial(self._simulate, fullest[:BATCH])
                if not self.busy:
                    return None
                self.changed.wait()
        return None

    def _resume(self, number: int, y: np.ndarray | None) -> None:
        try:
            wanted = next(self.searches[number]) if y is None else self.searches[number].send(y)
        except StopIteration as end:
            self.found[number] = end.value
            return
        request = _Request(number, wanted)
        with self.changed:
            for run in range(request.missing):
                self.waiting.setdefault(request.shared(run), []).append((request, run))

    def _simulate(self, runs: list[_Run]) -> None:
        for (request, run), y in zip(runs, _simulated(runs), strict=True):
            request.y[run] = y
        with self.changed:
            called.add(runs[0][0].code)
            self.in_the_making.discard(runs[0][0].code)
            for request, _ in runs:
                request.missing -= 1
                if not request.missing:
                    shape = (len(request.wanted.theta), len(request.wanted.logs), *request.y.shape[1:])
                    self.ready.append((request.search, request.y.reshape(shape)))
