"""Damaged inputs through the library, whole commands on damaged input, commands killed at random moments: what is wrong then."""

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hypothesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from rich.console import Console
from rich.progress import Progress

from tests.damage import commands
from tests.damage.kills import Kills
from tests.damage.trial import Damaged, Outcome, Shares, inputs, tried

CHUNK = 500
"""Inputs drawn in a row; the next ones begin from another seed."""
LINES = 50
"""Lines that say how far a run is, where stderr is no terminal."""
PROGRAMS, FITS, REGIONS = 60, 400, 20

Show = Callable[[str], None]
Try = Callable[[Path, Any], tuple[Damaged, Outcome]]


class Tally:
    """Counts what came of the inputs, and keeps the shortest input for every fault."""

    def __init__(self, keep: Path | None, show: Show) -> None:
        self.status: Counter[str] = Counter()
        self.faults: Counter[str] = Counter()
        self.shortest: dict[str, int] = {}
        self.slowest, self.keep, self.show = 0.0, keep, show

    def add(self, damaged: Damaged, outcome: Outcome) -> None:
        self.status[outcome.status] += 1
        self.slowest = max(self.slowest, outcome.seconds)
        for fault in outcome.faults:
            self.faults[fault] += 1
            size = sum(map(len, damaged.files.values()))
            if size < self.shortest.get(fault, size + 1):
                self.shortest[fault] = size
                self._keep(fault, damaged)
        self.show(self.words())

    def _keep(self, fault: str, damaged: Damaged) -> None:
        if self.keep is None:
            return
        place = self.keep / f"{list(self.shortest).index(fault):03d}"
        place.mkdir(parents=True, exist_ok=True)
        for name, content in {**damaged.files, "fault.txt": fault.encode("utf-8", "replace")}.items():
            (place / name).write_bytes(content)

    def words(self) -> str:
        kinds = ", ".join(f"{self.status[name]} {name}" for name in ("accepted", "refused", "failed"))
        return f"{self.status.total()} tried, {kinds}, {len(self.faults)} kinds of fault"

    def lines(self) -> list[str]:
        faults = [f"{times:6d}  {fault}" for fault, times in self.faults.most_common()]
        return [f"{self.words()}; the slowest took {self.slowest:.1f} s", *faults]


def drawn(count: int, seed: int, wanted: st.SearchStrategy, attempt: Try, tally: Tally) -> None:
    """Tries so many inputs, each in a folder of its own."""
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as folder:
        for begin in range(0, count, CHUNK):

            @hypothesis.seed(seed * 1_000_003 + begin)
            @settings(
                max_examples=min(CHUNK, count - begin),
                phases=[Phase.generate],
                database=None,
                deadline=None,
                suppress_health_check=list(HealthCheck),
            )
            @given(wanted)
            def one(found: Any) -> None:
                with tempfile.TemporaryDirectory(dir=folder) as own:
                    tally.add(*attempt(Path(own), found))

            one()


def main(arguments: list[str]) -> int:
    """Status 1 where anything is wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.damage", description=__doc__)
    parser.add_argument("--count", type=int, default=2000, help="damaged inputs, within this process")
    parser.add_argument("--commands", type=int, metavar="N", help="instead, whole commands on damaged input")
    parser.add_argument(
        "--kills",
        type=int,
        metavar="N",
        help="instead, commands killed, and a fifth as many beside another or on a full disk",
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, metavar="DIR", help="folder for the shortest input of every fault")
    options = parser.parse_args(arguments)
    count = options.commands or options.kills or options.count
    with Progress(console=Console(stderr=True)) as progress:
        tally = Tally(options.keep, shown(progress, count))
        if options.commands:
            drawn(count, options.seed, commands.calls(), lambda folder, call: commands.tried(folder, call), tally)
        elif options.kills:
            with Kills(options.seed) as kills:
                for found in kills.attempts(count):
                    tally.add(*found)
        else:
            shares = Shares(PROGRAMS, FITS, REGIONS)
            drawn(count, options.seed, inputs(vast=True), lambda folder, d: (d, tried(folder, d, shares)), tally)
    print("\n".join(tally.lines()))
    return int(bool(tally.faults))


def shown(progress: Progress, count: int) -> Show:
    """What is called with a line after every attempt, to be shown on a terminal, now and then otherwise."""
    task, done = progress.add_task("", total=count), Counter()

    def show(words: str) -> None:
        done["attempts"] += 1
        progress.update(task, advance=1, description=words)
        if not progress.console.is_terminal and done["attempts"] % -(-count // LINES) == 0:
            print(words, file=sys.stderr, flush=True)

    return show


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
