"""The project's benchmark of the end-to-end fit. `python -m experiments.speed.run [PART …]`; all parts without names.

Prints tables in Markdown and draws the curves into build/speed.png.
"""

import os
import platform
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from experiments.speed import c_limit, contenders, curves

PARTS = ("contenders", "fresh", "effects", "length", "threads", "starts")
PICTURE = c_limit.BUILD / "speed.png"


def machine() -> str:
    """Processor and load, in words."""
    cpu = Path("/proc/cpuinfo")
    model = (
        next((row.split(":")[1].strip() for row in cpu.read_text().splitlines() if "model name" in row), "")
        if cpu.exists()
        else ""
    )
    return f"{model or platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"


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


def main(parts: list[str]) -> None:
    """Runs the parts in order."""
    if unknown := [part for part in parts if part not in PARTS]:
        sys.exit(f"unknown part {', '.join(unknown)}; parts are {', '.join(PARTS)}")
    wanted = parts or list(PARTS)
    print(machine())
    if "contenders" in wanted:
        contenders.report(contenders.measure())
    if "fresh" in wanted:
        curves.fresh()
    over_effects = curves.effects() if "effects" in wanted else []
    over_length = curves.length() if "length" in wanted else []
    if "threads" in wanted:
        curves.threads()
    if "starts" in wanted:
        curves.starts()
    if over_effects or over_length:
        draw(over_effects, over_length)


if __name__ == "__main__":
    main(sys.argv[1:])
