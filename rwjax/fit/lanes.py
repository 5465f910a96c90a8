"""Free runs of many searches side by side.

A search is a generator that yields what it wants to see simulated and is sent the readings. Whatever several searches wait
for at a time goes through one program together, a log with its parameter vector and first state to a lane: a lane of a full
call costs a third of a call of its own.
"""

import os
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np
from threadpoolctl import ThreadpoolController

from rwjax.fit.problem import Problem
from rwjax.simulate import free_runs

LANES = 16
"""Free runs in one call."""
THREADS = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Wanted(NamedTuple):
    """Free runs of some `logs` of a problem for parameter vectors `theta` (b, t) from first states `start` (b, l, n), in their
    first `windows`. What is sent back are readings `(b, logs, windows, q, y)`."""

    problem: Problem
    theta: np.ndarray
    start: np.ndarray
    logs: np.ndarray
    windows: int


BLAS = ThreadpoolController().select(user_api="blas")
"""The threads of matrix products would wait for their next one busily, on the cores that the runs need."""

T = TypeVar("T")
Search = Generator[Wanted, np.ndarray, T]


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
        self.y = np.zeros((self.missing, self.wanted.windows, slots, len(self.wanted.problem.structure.outputs)))

    @property
    def program(self) -> tuple:
        """Lanes of which requests go together."""
        batch = self.wanted.problem.batch
        return self.wanted.problem.structure, id(batch.slot_step), id(batch.which), id(batch.plus), self.wanted.windows


def _run(part: list[tuple[_Asked, int]]) -> np.ndarray:
    """Readings of some lanes, each a request and the number of the lane in it."""
    full = [*part, *part[-1:] * (LANES - len(part))]  # the last one again fills the lanes
    row = [divmod(lane, len(asked.wanted.logs)) for asked, lane in full]
    theta = np.stack([asked.wanted.theta[b] for (asked, _), (b, _) in zip(full, row, strict=True)])
    log = np.array([asked.wanted.logs[k] for (asked, _), (_, k) in zip(full, row, strict=True)])
    start = np.stack([asked.wanted.start[b, k] for (asked, _), (b, _), k in zip(full, row, log, strict=True)])
    wanted = part[0][0].wanted
    batch = wanted.problem.batch.inputs_of(log)
    y = free_runs(wanted.problem.structure, theta, start, np.array(wanted.windows), batch)
    return np.asarray(y)[: len(part), : wanted.windows]


def together(searches: Sequence[Search[T]]) -> list[T]:
    """What several searches return, all carried out side by side."""
    found: dict[int, T] = {}
    waiting: dict[tuple, list[tuple[_Asked, int]]] = {}
    running: dict[Future, list[tuple[_Asked, int]]] = {}

    def go_on(number: int, y: np.ndarray | None) -> None:
        try:
            wanted = next(searches[number]) if y is None else searches[number].send(y)
        except StopIteration as end:
            found[number] = end.value
            return
        asked = _Asked(number, wanted)
        waiting.setdefault(asked.program, []).extend((asked, lane) for lane in range(asked.missing))

    with BLAS.limit(limits=1), ThreadPoolExecutor(THREADS) as pool:
        for number in range(len(searches)):
            go_on(number, None)
        while running or waiting:
            while waiting and len(running) < THREADS:
                fullest = max(waiting, key=lambda program: len(waiting[program]))
                lanes = waiting.pop(fullest)
                if lanes[LANES:]:
                    waiting[fullest] = lanes[LANES:]
                running[pool.submit(_run, lanes[:LANES])] = lanes[:LANES]
            for done in wait(running, return_when=FIRST_COMPLETED).done:
                y = done.result()
                part = running.pop(done)
                for k, (asked, lane) in enumerate(part):
                    asked.y[lane] = y[k]
                    asked.missing -= 1
                    if not asked.missing:
                        shape = (len(asked.wanted.theta), len(asked.wanted.logs), *asked.y.shape[1:])
                        go_on(asked.search, asked.y.reshape(shape))
    return [found[number] for number in range(len(searches))]
