"""Times in interleaved rounds, medians and tables in Markdown."""

import os
import platform
import statistics
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

Result = TypeVar("Result")
ROUNDS = 9
OF_SLOW = 3
"""Rounds in which a slow contender takes part."""


class Raced(NamedTuple):
    """Seconds a call of every contender, round by round, and what each returned last."""

    times: dict[str, list[float]]
    results: dict[str, Any]

    def median(self, name: str) -> float:
        """Seconds of the middle round."""
        return statistics.median(self.times[name])

    def ratio(self, name: str, other: str) -> float:
        """How many times the seconds of another a contender takes."""
        return ratio(self.times[name], self.times[other])


def timed(call: Callable[..., Result], *arguments: object) -> tuple[float, Result]:
    """Seconds that a call took, and what it returned."""
    begin = time.perf_counter()
    result = call(*arguments)
    return time.perf_counter() - begin, result


def race(
    contenders: Mapping[str, Callable[[], Any]],
    rounds: int = ROUNDS,
    slow: Collection[str] = (),
    repeats: int = 1,
) -> Raced:
    """Times contenders in interleaved rounds, so that what else the machine does meets all of them.

    Each is called once before, and in a round counts by the best of `repeats` calls. A slow one is not called before, and takes part
    in the first rounds only, with one call in each.
    """
    results = {name: call() for name, call in contenders.items() if name not in slow}
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for k in range(rounds):
        for name, call in contenders.items():
            if name in slow and k >= OF_SLOW:
                continue
            spent = []
            for _ in range(1 if name in slow else repeats):
                took, results[name] = timed(call)
                spent.append(took)
            times[name].append(min(spent))
    return Raced(times, results)


def machine() -> str:
    """Processor and load, in words."""
    cpu = Path("/proc/cpuinfo")
    model = (
        next((row.split(":")[1].strip() for row in cpu.read_text().splitlines() if "model name" in row), "")
        if cpu.exists()
        else ""
    )
    return f"{model or platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"


def ratio(times: Sequence[float], others: Sequence[float]) -> float:
    """Median of the ratios round by round."""
    return statistics.median(a / b for a, b in zip(times, others, strict=False))


class Table(NamedTuple):
    """What `show` prints: a title, the heads of the columns and the rows."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    return "\n".join(
        ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head), *(f"| {' | '.join(r)} |" for r in rows)]
    )


def show(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Prints a Markdown table."""
    print(f"\n### {title}\n\n{markdown(head, rows)}\n", flush=True)


def seconds(value: float) -> str:
    """A time with its unit to three digits."""
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"
