"""How long a diagnosis takes where two causes are missing, or one that is not on the list of effects.

`python -m experiments.speed.causes -o build/causes.jsonl [--cases 40] [--most SECONDS] [--set explore]` diagnoses each case twice in this
process: the first time may compile, the second has all its programs. It appends a line a case, skips what the file holds already, and
prints the table of the whole file. A second diagnosis that takes longer than `--most` is broken off and counts as longer than all others.
`--xla` does all of it by XLA's programs, the yardstick; give it a file of its own.

Half of the cases lack two effects, the other half has a cause outside the list. The first n of them are the same whatever n is.
"""

import argparse
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from itertools import chain
from json import dumps
from pathlib import Path
from types import FrameType

import numpy as np
from scipy.stats import binom

from experiments.blind.campaign import answer
from experiments.blind.draw import PLANS, appending, cases, read
from experiments.speed.lowering import xla_only
from experiments.speed.table import machine, show
from rwjax.fitting.processes import Team

GROUPS = {"pair": "two causes", "outside": "one outside the list"}
CASES = 40
LEVEL = 0.95
"""Of the intervals, which hold whatever the times' distribution is."""
FIRST = 4.0
"""Times as long as the second may the first diagnosis take, which compiles."""
Work = Callable[[dict, AbstractContextManager], dict]
QUANTILES = {"median": 0.5, "95 %": 0.95}


class OutOfTime(Exception):
    """A diagnosis took longer than it may; the library ends as by Ctrl-C."""


@contextmanager
def at_most(seconds: float | None) -> Iterator[None]:
    """`OutOfTime` in the main thread once the time is over; no limit without a time."""

    def over(number: int, frame: FrameType | None) -> None:
        raise OutOfTime(f"not done after {seconds:g} s")

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, seconds or 0.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def chosen(rows: Sequence[dict], count: int) -> list[dict]:
    """So many cases, of both groups in turn, in a random order that does not depend on the count."""
    rng = np.random.default_rng(0)
    each = []
    for name in GROUPS:
        group = [row for row in rows if row["group"] == name]
        each.append([group[k] for k in rng.permutation(len(group))])
    return list(chain.from_iterable(zip(*each, strict=False)))[:count]


def as_the_command(row: dict, within: AbstractContextManager) -> dict:
    """`answer` on all cores, as the command `diagnose` has it."""
    with Team() as team:
        return answer(row, within, team)


def diagnosed(row: dict, most: float | None, work: Work = as_the_command) -> dict:
    """A case's line: what the second diagnosis says, its `seconds`, and those of the `first`."""
    first = work(row, at_most(most and FIRST * most))
    return work(row, at_most(most)) | {"first": first["seconds"], "most": most}


def run(rows: Sequence[dict], path: Path, most: float | None, work: Work = as_the_command) -> None:
    """Appends the line of every case that the file does not hold."""
    done = {line["index"] for line in read(path)}
    rest = [row for row in rows if row["index"] not in done]
    with appending(path) as file:
        for count, row in enumerate(rest, 1):
            file.write(dumps(diagnosed(row, most, work)) + "\n")
            file.flush()
            print(f"\r{count} of {len(rest)}", end="", flush=True)
    print()


def times(lines: Sequence[dict]) -> np.ndarray:
    """Seconds of each diagnosis, infinite where it was broken off."""
    over = [line.get("error", "").startswith(OutOfTime.__name__) for line in lines]
    return np.array([np.inf if late else line["seconds"] for late, line in zip(over, lines, strict=True)])


def quantile(values: np.ndarray, share: float) -> tuple[float, float, float]:
    """A quantile of what the values were drawn from, and its interval by order statistics; open where they are too few."""
    ordered, count = np.sort(values), len(values)
    low = int(binom.ppf(0.5 - LEVEL / 2.0, count, share))
    high = int(binom.ppf(0.5 + LEVEL / 2.0, count, share)) + 1
    middle = ordered[int(np.ceil(share * count)) - 1]
    return float(middle), float(ordered[low - 1]) if low else 0.0, float(ordered[high - 1]) if high <= count else np.inf


def said(value: float, most: float | None) -> str:
    """Seconds in words."""
    return f"{value:.1f}" if np.isfinite(value) else f"over {most:g}" if most else "∞"


def report(lines: Sequence[dict]) -> None:
    """Prints the table."""
    rows = []
    for title, groups in [*((words, (name,)) for name, words in GROUPS.items()), ("all", tuple(GROUPS))]:
        some = [line for line in lines if line["group"] in groups]
        if not some:
            continue
        spent, cells = times(some), []
        for share in QUANTILES.values():
            middle, low, high = quantile(spent, share)
            cells.append(f"{said(middle, some[0]['most'])} ({said(low, some[0]['most'])} to {said(high, None)})")
        late = np.isinf(spent)
        failed = sum("error" in line for line in some) - int(late.sum())
        first = float(np.median([line["first"] for line in some]))
        rows.append([title, str(len(some)), f"{first:.1f}", *cells, str(int(late.sum())), str(failed)])
    head = ["cases with", "", "first, median [s]", *(f"{name} [s] (95 % interval)" for name in QUANTILES)]
    show(f"`diagnose` with every program compiled; {machine()}", [*head, "broken off", "failed"], rows)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="path", type=Path, required=True)
    parser.add_argument("--set", dest="name", choices=PLANS, default="explore")
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--most", type=float, metavar="SECONDS", help="of one diagnosis")
    parser.add_argument("--xla", action="store_true")
    a = parser.parse_args()
    with xla_only() if a.xla else nullcontext():
        run(chosen([*cases(a.name)], a.cases), a.path, a.most)
    report(read(a.path))


if __name__ == "__main__":
    main()
