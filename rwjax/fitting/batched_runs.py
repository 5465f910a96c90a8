"""Free runs of many searches side by side.

A search is a generator that yields what it wants to see simulated and is sent the readings. Whatever several searches wait
for at a time goes through one program together, a log with its parameter vector and first state to a lane: a lane of a full
call costs a third of a call of its own.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from functools import partial
from threading import Condition
from typing import Any, NamedTuple, TypeVar

import numpy as np

from rwjax.fitting.problem import Problem
from rwjax.fitting.threads import THREADS, pool_of_threads
from rwjax.simulation.shooting import free_runs

BATCH = 16
"""Free runs in one call."""


class Wanted(NamedTuple):
    """Free runs of some `logs` of a problem for parameter vectors `theta` (b, t) from first states `start` (b, l, n), in their
    first `windows`. What is sent back are readings `(b, logs, windows, q, y)`, which are the search's own to change."""

    problem: Problem
    theta: np.ndarray
    start: np.ndarray
    logs: np.ndarray
    windows: int


T = TypeVar("T")
Simulating = Generator[Wanted, np.ndarray, T]


@dataclass
class _Asked:
    """What search number `search` waits for; `missing` lanes of its readings `y` (lanes, w, q, y) are still to come."""

    search: int
    wanted: Wanted
    y: np.ndarray = field(init=False)
    missing: int = field(init=False)

    def __post_init__(self) -> None:
        batch = self.wanted.problem.batch
        self.missing = len(self.wanted.theta) * len(self.wanted.logs)
        slots = batch.slot_step.shape[2]
        self.y = np.empty((self.missing, self.wanted.windows, slots, len(self.wanted.problem.structure.outputs)))

    @property
    def program(self) -> tuple:
        """Lanes of which requests go together."""
        batch = self.wanted.problem.batch
        return (
            self.wanted.problem.structure,
            id(batch.slot_step),
            id(batch.theta_index),
            id(batch.theta_offset),
            self.wanted.windows,
        )


def _run(part: list[tuple[_Asked, int]]) -> np.ndarray:
    """Readings of some lanes, each a request and the number of the lane in it."""
    full = [*part, *part[-1:] * (BATCH - len(part))]  # the last one again fills the lanes
    row = [divmod(lane, len(asked.wanted.logs)) for asked, lane in full]
    theta = np.stack([asked.wanted.theta[b] for (asked, _), (b, _) in zip(full, row, strict=True)])
    log = np.array([asked.wanted.logs[k] for (asked, _), (_, k) in zip(full, row, strict=True)])
    start = np.stack([asked.wanted.start[b, k] for (asked, _), (b, _), k in zip(full, row, log, strict=True)])
    wanted = part[0][0].wanted
    batch = wanted.problem.batch.inputs_of(log)
    y = free_runs(wanted.problem.structure, theta, start, np.array(wanted.windows), batch)
    return np.asarray(y)[: len(part), : wanted.windows]


def together(searches: Sequence[Simulating[T]]) -> list[T]:
    """What several searches return, all carried out side by side."""
    work = _Work([*searches])
    with pool_of_threads() as pool:
        try:
            crew = [pool.submit(work.until_done) for _ in range(THREADS)]
            for member in crew:
                member.result()
        finally:
            work.stop()
    return [work.found[number] for number in range(len(searches))]


class _Work:
    """Searches on their way: each thread takes lanes that fill a call, else goes on with the search whose readings came last, else
    runs the lanes that there are."""

    def __init__(self, searches: list[Simulating[Any]]) -> None:
        self.searches = searches
        self.found: dict[int, Any] = {}
        self.ready: list[tuple[int, np.ndarray | None]] = [(number, None) for number in reversed(range(len(searches)))]
        self.waiting: dict[tuple, list[tuple[_Asked, int]]] = {}
        self.busy = 0
        self.stopped = False
        self.changed = Condition()

    def stop(self) -> None:
        """Nothing more is begun."""
        with self.changed:
            self.stopped = True
            self.changed.notify_all()

    def until_done(self) -> None:
        """What one thread does."""
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
                fullest = max(self.waiting, key=lambda program: len(self.waiting[program]), default=None)
                if self.ready and (fullest is None or len(self.waiting[fullest]) < BATCH):
                    self.busy += 1
                    return partial(self._go_on, *self.ready.pop())
                if fullest is not None:
                    lanes = self.waiting.pop(fullest)
                    if lanes[BATCH:]:
                        self.waiting[fullest] = lanes[BATCH:]
                    self.busy += 1
                    return partial(self._simulate, lanes[:BATCH])
                if not self.busy:
                    return None
                self.changed.wait()
        return None

    def _go_on(self, number: int, y: np.ndarray | None) -> None:
        try:
            wanted = next(self.searches[number]) if y is None else self.searches[number].send(y)
        except StopIteration as end:
            self.found[number] = end.value
            return
        asked = _Asked(number, wanted)
        with self.changed:
            self.waiting.setdefault(asked.program, []).extend((asked, lane) for lane in range(asked.missing))

    def _simulate(self, part: list[tuple[_Asked, int]]) -> None:
        for (asked, lane), y in zip(part, _run(part), strict=True):
            asked.y[lane] = y
        with self.changed:
            for asked, _ in part:
                asked.missing -= 1
                if not asked.missing:
                    shape = (len(asked.wanted.theta), len(asked.wanted.logs), *asked.y.shape[1:])
                    self.ready.append((asked.search, asked.y.reshape(shape)))
