"""One hour at 1 kHz, 3.6 million samples: `python -m experiments.speed.hour [--hours 1] [PART …]`

Prints seconds and peak memory of `rwjax predict` (which reads, and runs the rig once), `fit` and `diagnose` on one log of the separate
simulator, a platform that lacks Stribeck friction. Each is a process of its own; its helpers count with it, and what they share counts once.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

from experiments.blind.commands import TICK, command
from experiments.blind.simulator import simulate
from experiments.blind.truth import PSI
from experiments.speed.diagnosis import CASES, COUNTS, RIGS, ROOT
from experiments.speed.table import machine, show
from rwjax import write_log

STEP = 1e-3  # s
PIECE = 60.0  # s of one command
KINDS = ("square", "multisine", "triangle", "stair", "mixed")
CALLS = {
    "predict": ("predict", "rig.toml", "hour.csv", "-o", "predicted.csv"),
    "fit": ("fit", "rig.toml", "hour.csv", "--force", "-o", "fitted.toml"),
    "diagnose": ("diagnose", "rig.toml", "hour.csv", "--force", "--budget", "inf", "-o", "out"),
}


def write_hour(folder: Path, hours: float) -> int:
    """Writes rig file and log; the number of samples."""
    rng, truth = np.random.default_rng(5), CASES["platform, Stribeck friction"]
    pieces = [command(KINDS[k % len(KINDS)], PIECE, 6.0, rng) for k in range(round(3600.0 * hours / PIECE))]
    u = np.repeat(np.concatenate(pieces), round(TICK / STEP))
    t = np.round(STEP * np.arange(len(u)), 3)
    counts = np.floor(simulate(t, u, t, np.zeros(5), truth.array())[:, PSI] * COUNTS / (2.0 * np.pi) + 0.5)
    (folder / "rig.toml").write_text(RIGS[truth.kind])
    write_log(folder / "hour.csv", {"time_s": t, "voltage_V": u, "yaw_counts": counts}, {})
    return len(t)


def measured(call: tuple[str, ...], folder: Path) -> tuple[float, float, str]:
    """Seconds, peak memory [GiB] of the process with its helpers, and the last line that it said."""
    begin, peak = time.perf_counter(), 0
    own = subprocess.Popen(
        [sys.executable, "-m", "rwjax", *call, "--quiet"],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    process = psutil.Process(own.pid)
    while own.poll() is None:
        try:
            peak = max(peak, sum(p.memory_full_info().pss for p in (process, *process.children(recursive=True))))
        except (psutil.NoSuchProcess, psutil.AccessDenied):
            pass
        time.sleep(0.2)
    said = own.stdout.read().strip().split("\n") if own.stdout else [""]
    return time.perf_counter() - begin, peak / 2**30, said[0][:160]


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(CALLS))
    parser.add_argument("--hours", type=float, default=1.0)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        samples, rows = write_hour(Path(name), a.hours), []
        for part in a.parts or CALLS:
            seconds, peak, said = measured(CALLS[part], Path(name))
            rows.append([part, f"{seconds:.1f}", f"{peak:.2f}", said])
        show(f"{samples} samples; {machine()}", ["command", "time [s]", "peak memory [GiB]", "says first"], rows)


if __name__ == "__main__":
    main()
