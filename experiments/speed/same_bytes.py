"""Does a diagnosis give the same bytes? `python -m experiments.speed.same_bytes [CASE …]`, the cases of `experiments.speed.diagnosis`.

Each case is diagnosed by `rwjax diagnose` in processes of their own: twice on all processors that this process may use, and once on a
single one. Only times that `diagnosis.json` holds may differ. The end status is 1 where anything else does.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from experiments.speed.diagnosis import CASES, environment, write
from experiments.speed.table import show

TIME = re.compile(rb'("(?:seconds|\w+_seconds)":\s*)[-+.\deE]+')
"""A time that a diagnosis took, with the key before it; the schema has none yet. Times in a log have other keys (`from_s`)."""


def without_times(text: bytes) -> bytes:
    """The text with every time that the work took as 0."""
    return TIME.sub(rb"\g<1>0", text)


def first_difference(one: bytes, other: bytes) -> str:
    """The first lines that differ, in words; empty where none does."""
    rows, others = without_times(one).splitlines(), without_times(other).splitlines()
    for number, (row, beside) in enumerate(zip(rows, others, strict=False), 1):
        if row != beside:
            return f"line {number}: {row.decode().strip()} | {beside.decode().strip()}"
    if len(rows) != len(others):
        return f"{len(rows)} lines | {len(others)}"
    return "" if without_times(one) == without_times(other) else "ends of lines"


def diagnosed(folder: Path, logs: list[str], cache: Path, processors: set[int]) -> bytes:
    """`diagnosis.json` by a process on some processors alone."""
    own = os.sched_getaffinity(0)
    command = [sys.executable, "-m", "rwjax", "diagnose", "rig.toml", *logs, "--quiet", "-o", "out"]
    os.sched_setaffinity(0, processors)  # which the process inherits, and so before it asks how many there are
    try:
        subprocess.run(command, cwd=folder, env=environment(cache), check=True, stdout=subprocess.DEVNULL)
    finally:
        os.sched_setaffinity(0, own)
    return (folder / "out" / "diagnosis.json").read_bytes()


def compared(name: str) -> list[str]:
    """What a second run, and a run on a single processor, say otherwise than the first."""
    every = os.sched_getaffinity(0)
    with tempfile.TemporaryDirectory() as folder:
        logs = write(CASES[name], Path(folder))
        first, again, alone = (
            diagnosed(Path(folder), logs, Path(folder) / "cache", processors)
            for processors in (every, every, {min(every)})
        )
    return [first_difference(first, again), first_difference(first, alone)]


def main(names: list[str]) -> None:
    """Prints a line for each case."""
    if unknown := {*names} - {*CASES}:
        sys.exit(f"unknown case {', '.join(unknown)}; cases are {'; '.join(CASES)}")
    count = len(os.sched_getaffinity(0))
    if count == 1:
        sys.exit("only one processor may be used: nothing to compare a single thread with")
    found = {name: compared(name) for name in names or CASES}
    rows = [[name, *(difference or "the same bytes" for difference in pair)] for name, pair in found.items()]
    show("`diagnosis.json`, but for times", ("case", f"{count} threads twice", f"{count} threads and one"), rows)
    sys.exit(any(difference for pair in found.values() for difference in pair))


if __name__ == "__main__":
    main(sys.argv[1:])
