"""Times, medians and tables in Markdown."""

import statistics
import time
from collections.abc import Callable, Sequence
from typing import TypeVar

Result = TypeVar("Result")


def timed(call: Callable[..., Result], *arguments: object) -> tuple[float, Result]:
    """Seconds that a call took, and what it returned."""
    begin = time.perf_counter()
    result = call(*arguments)
    return time.perf_counter() - begin, result


def ratio(times: Sequence[float], others: Sequence[float]) -> float:
    """Median of the ratios round by round."""
    return statistics.median(a / b for a, b in zip(times, others, strict=False))


def show(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Prints a Markdown table."""
    print(f"\n### {title}\n")
    print("| " + " | ".join(head) + " |")
    print("|" + " --- |" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print(flush=True)


def seconds(value: float) -> str:
    """A time with its unit to three digits."""
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"
