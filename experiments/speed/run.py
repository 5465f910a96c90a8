"""The project's benchmark of the end-to-end fit. `python -m experiments.speed.run [--quick] [PART …]`; all parts without names.

Prints tables in Markdown and draws the curves into build/speed.png. `--quick` takes each part at its smallest size, to see that it
works: its figures mean nothing.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from experiments.speed import c_limit, contenders, curves, free_runs, processes
from experiments.speed.shared import RIGS, shared
from experiments.speed.table import machine

PICTURE = c_limit.BUILD / "speed.png"


PARTS: dict[str, Callable[[bool], list | None]] = {
    "contenders": lambda quick: contenders.report(contenders.measure(quick)),
    "runs": lambda quick: free_runs.runs(5.0, 1, 1) if quick else free_runs.runs(),
    "shared": lambda quick: shared(RIGS[:1], 1, 1) if quick else shared(),
    "fresh": lambda quick: processes.fresh(1 if quick else 5),
    "compile": lambda quick: processes.compile(1, ["wheel"]) if quick else processes.compile(),
    "memory": lambda quick: processes.memory((10.0,), ()) if quick else processes.memory(curves.LENGTHS),
    "effects": lambda quick: curves.effects((0, 1), 1) if quick else curves.effects(),
    "length": lambda quick: curves.length((10.0, 20.0), 1) if quick else curves.length(),
    "logs": lambda quick: curves.logs((1, 2), 1) if quick else curves.logs(),
    "threads": lambda quick: curves.threads(2, 1) if quick else curves.threads(),
    "starts": lambda quick: curves.starts(2) if quick else curves.starts(),
}
"""Each part, at its smallest size or whole; some return the points of a curve."""


def draw(over_effects: list, over_length: list) -> None:
    """The curves over free numbers and log length."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    if over_effects:
        free, time = np.array(over_effects).T
        left.plot(free, 1e3 * time, "o-")
    left.set(xlabel="free numbers", ylabel="warm fit [ms]", title="60 s log", ylim=(0, None))
    if over_length:
        duration, ours, limit = np.array(over_length).T
        right.loglog(duration, ours, "o-", label="rwjax, fit")
        right.loglog(duration, limit, "s-", label="C")
        right.loglog(duration, ours[-1] * duration / duration[-1], ":", color="grey", label="linear")
        right.legend(frameon=False)
    right.set(xlabel="length of the log [s]", ylabel="warm fit [s]")
    c_limit.BUILD.mkdir(exist_ok=True)
    figure.savefig(PICTURE, dpi=150)
    print(f"{PICTURE.relative_to(Path.cwd()) if PICTURE.is_relative_to(Path.cwd()) else PICTURE}")


def main() -> None:
    """Runs the parts in order."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--quick", action="store_true")
    a = parser.parse_args()
    if unknown := [part for part in a.parts if part not in PARTS]:
        parser.error(f"unknown part {', '.join(unknown)}; parts are {', '.join(PARTS)}")
    print(machine())
    points = {part: run(a.quick) for part, run in PARTS.items() if not a.parts or part in a.parts}
    if {"effects", "length"} & {*points}:
        draw(points.get("effects") or [], points.get("length") or [])


if __name__ == "__main__":
    main()
